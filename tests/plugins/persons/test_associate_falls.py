"""People who fall, lie and get up, and people who are lost for a while, keep their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.box_bodies import standing
from tests.plugins.persons.crowded import corner_room

from followspot import Array, Context
from followspot.geometry import project
from followspot.messages import Header, stamped
from followspot.people import Boxes, Poses
from followspot_persons.associate.boxes.ellipsoid import SIZE, boxes_of
from followspot_persons.associate.boxes.model import BoxModel
from followspot_persons.associate.boxes.shape_mixture import ShapeMixture
from followspot_persons.associate.boxes.tracks import BoxTracks, fitted
from followspot_persons.associate.colors.torso_colors import BINS
from followspot_persons.associate.colors.track_colors import unknown_colors
from followspot_persons.associate.multi_view.views import views_of
from followspot_persons.associate.stage import Associate
from followspot_persons.associate.tracks.confirmation import confirmed
from followspot_persons.associate.tracks.lost_people import LostPeople, found_again
from followspot_persons.associate.tracks.tracks import LifeCycles, Tracks

ROOM = corner_room()
PERIOD = 0.25
TALL = 1.75
SECOND = 10**9


def body(xy: Array, tilt: float, way: float) -> Array:
    """Points (P, 3) m on a person who stands at xy, tilted to the floor by an angle in a direction, rad."""
    up, angle = (part.ravel() for part in np.meshgrid(np.linspace(0.1, TALL - 0.1, 12), np.linspace(0, 6, 8)))
    across, aside = 0.22 * np.cos(angle), 0.18 * np.sin(angle)
    ahead, height = across * np.cos(tilt) + up * np.sin(tilt), up * np.cos(tilt) - across * np.sin(tilt)
    turned = np.column_stack(
        [ahead * np.cos(way) - aside * np.sin(way), ahead * np.sin(way) + aside * np.cos(way)]
    )
    return np.column_stack([xy + turned, height + 0.15 * np.sin(tilt)])


def boxes(people: Sequence[Array], time: float, rng: np.random.Generator) -> tuple[Boxes, ...]:
    """The boxes about people's points in each camera."""
    sets = []
    for camera in ROOM.cameras.values():
        pixels = np.array([project(camera, one) for one in people])
        box = np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=-1)
        box += rng.normal(0, 0.02, box.shape) * np.hypot(*(box[:, 2:] - box[:, :2]).T)[:, None]
        box, none = box.clip(0, np.tile(np.array(camera.size) - 1, 2)), np.zeros((len(box), 0))
        sent = Header("boxes", 0, round(time * SECOND))
        sets.append(stamped(Boxes(camera.name, box, np.ones(len(box)), none, none), sent))
    return tuple(sets)


def tilted(seconds: float) -> float:
    """Angle of a person who falls after 2 s, within half a second, and gets up after 5 s, rad."""
    return float(np.interp(seconds, [2.0, 2.5, 5.0, 6.2], [0.0, np.pi / 2, np.pi / 2, 0.0]))


@pytest.mark.parametrize("way", np.radians([0, 40, 90, 200]))
def test_who_falls_lies_and_gets_up_keeps_the_number(way: float) -> None:
    """The pose is at the place, too, but in the half second of the fall and while the person gets up."""
    stage = Associate(Context("associate", ROOM))
    stage.setup()
    rng = np.random.default_rng(4)
    for time in np.arange(1, 9, PERIOD):
        points = body(np.array([0.2, -0.1]), tilted(time), way)
        poses = stage.process(boxes=boxes([points], time, rng)).poses
        if time >= 2:
            assert poses.person.tolist() == [1], time
        if 1.5 < time <= 2 or 2.75 <= time <= 5 or time >= 6.5:
            middle = (points.min(axis=0) + points.max(axis=0))[:2] / 2
            assert np.linalg.norm(poses.xy[0] - middle) < 0.15, time
            assert poses.height[0] == pytest.approx(points[:, 2].max(), abs=0.25), time


def test_three_cameras_tell_that_somebody_crouches_and_stands_up() -> None:
    model, views = BoxModel(0.01, np.array([0.0, 0.0, 1.0, 0.0])), views_of(tuple(ROOM.cameras.values()))
    rng, row, sure = np.random.default_rng(6), np.zeros(1, int), np.ones(1)
    standing = body(np.array([0.2, -0.1]), 0.0, 0.0)
    crouching = standing * [1.0, 1.0, 0.55]

    def after(bodies: ShapeMixture, points: Array, cameras: Sequence[int]) -> ShapeMixture:
        bodies = model.predicted(model.before_set(bodies), PERIOD)
        seen = boxes([points], 0.0, rng)
        for camera in cameras:
            bodies = model.updated(bodies, row, views.each[camera], seen[camera].box, sure)
        return bodies

    first = [one.box[0] for one in boxes([standing], 0.0, rng)]
    bodies = model.initiated(views, np.arange(4), np.array(first))
    assert bodies is not None
    for _ in range(4):
        bodies = after(bodies, standing, range(4))
    assert bodies.shape[0, 0] > 0.99
    bodies = after(bodies, crouching, (0, 1, 2))
    assert bodies.shape[0, 0] < 0.1
    bodies = after(bodies, crouching, (0, 1, 2))
    assert bodies.mean.state[0, 2] == pytest.approx(crouching[:, 2].mean(), abs=0.1)
    bodies = after(bodies, standing, (0, 1, 2))
    assert bodies.shape[0, 0] > 0.9


def test_boxes_of_a_lying_body_are_as_inexact_as_it_is_long() -> None:
    view = views_of(tuple(ROOM.cameras.values())).each[0]
    lying = np.zeros((1, SIZE))
    lying[0, 2], lying[0, 6:] = 0.15, [np.log(0.4), np.log(0.15), 0.0, -0.7]
    box, _ = boxes_of(view, lying)
    width, height = box[0, 2:] - box[0, :2]
    assert width > 2.5 * height
    bodies = BoxTracks(lying, 1e-6 * np.eye(SIZE)[None], np.zeros(1, int))
    assert fitted(bodies, view, box + 0.08 * width, 0.01).ratio[0, 0] > 0
    assert fitted(bodies, view, box + 0.6 * width, 0.01).ratio[0, 0] == -np.inf


@pytest.mark.parametrize(("away", "same"), [(1.75, True), (6.0, False)])
def test_who_is_found_again_near_and_soon_keeps_the_number(away: float, same: bool) -> None:
    """No camera finds the person in the middle for some seconds; the other is found all the time."""
    stage = Associate(Context("associate", ROOM), recall_time=3.0)
    stage.setup()
    rng, seen = np.random.default_rng(5), []
    for time in np.arange(0, away + 4, PERIOD):
        there = [body(np.array([-1.2, 0.9]), 0.0, 0.0)]
        if not 2 <= time < 2 + away:
            there.append(body(np.array([0.1 if time < 2 else 0.5, 0.0]), 0.0, 0.0))
        seen.append(stage.process(boxes=boxes(there, time, rng)).poses)
    gap = seen[int((2 + away) / PERIOD) - 1]
    assert len(gap.person) == 1
    assert sorted(seen[-1].person) == ([1, 2] if same else [gap.person[0], 3])
    assert middle_one(seen[-1]) == (middle_one(seen[7]) if same else 3)


def middle_one(poses: Poses) -> int:
    """The number of who is next to the middle."""
    return int(poses.person[np.hypot(*poses.xy.T).argmin()])


def lost(*xy: tuple[float, float], velocity: tuple[float, float] = (0.0, 0.0)) -> LostPeople:
    """People 1, 2 ... that were lost at these places, m, at time 0."""
    count = len(xy)
    number, colors = np.arange(1, count + 1), np.full((count, 4, BINS), np.nan)
    return LostPeople(number, np.array(xy), np.tile(velocity, (count, 1)), np.zeros(count, int), colors)


def again(people: LostPeople, *xy: tuple[float, float], colors: Array | None = None) -> dict[int, int]:
    """The number of each new one that is somebody lost, one second later."""
    unknown = np.full((len(xy), 4, BINS), np.nan)
    rows, new = found_again(people, np.array(xy), unknown if colors is None else colors, SECOND)
    return dict(zip(new.tolist(), people.number[rows].tolist(), strict=True))


def test_each_of_two_lost_people_is_the_nearer_new_one() -> None:
    two = lost((0.0, 0.0), (0.6, 0.0))
    assert again(two, (0.5, 0.1), (-0.2, 0.0)) == {0: 2, 1: 1}
    assert again(two, (0.5, 0.1)) == {0: 2}
    assert again(two, (4.0, 0.0)) == {}
    assert again(lost((0.0, 0.0), velocity=(2.0, 0.0)), (2.3, 0.0)) == {0: 1}
    assert again(lost((0.0, 0.0)), (2.3, 0.0)) == {}


def test_colours_tell_two_lost_people_apart() -> None:
    two, new = lost((0.0, 0.0), (0.4, 0.0)), np.zeros((2, 4, BINS))
    new[0, :, 1], new[1, :, 5] = 1.0, 1.0
    two.colors[:] = new[::-1]
    assert again(two, (0.0, 0.0), (0.4, 0.0), colors=new) == {0: 2, 1: 1}
    assert again(two, (0.0, 0.0), (0.4, 0.0)) == {0: 1, 1: 2}


def people(numbers: Sequence[int], *xy: tuple[float, float]) -> Tracks[ShapeMixture]:
    """Tracks at these places, m, as sure as can be; number: 0 of those that are not confirmed yet."""
    count = len(numbers)
    life = LifeCycles(np.array(numbers), np.full(count, 8.0), np.zeros(count, int), unknown_colors(count, 4))
    return Tracks(standing(*xy), life, SECOND, 5, np.zeros((4, 2), int), LostPeople.none(4))


def confirm(
    tracks: Tracks[ShapeMixture], missed: Sequence[bool], recalled: int = SECOND
) -> Tracks[ShapeMixture]:
    model = BoxModel(0.01, np.array([0.0, 0.0, 1.0, 0.0]))
    return confirmed(tracks, model, np.array(missed), 4.0, recalled)


def test_a_new_track_replaces_that_of_a_person_nearby_whom_no_camera_found() -> None:
    two = people([3, 0], (0.0, 0.0), (0.5, 0.0))
    after = confirm(two, [True, False])
    assert after.life.number.tolist() == [3]
    assert after.bodies.mean.state[0, 0] == pytest.approx(0.5)
    assert confirm(two, [False, False]).life.number.tolist() == [3, 6]
    assert confirm(two, [True, False], recalled=0).life.number.tolist() == [3, 6]
    assert confirm(people([3, 0], (0.0, 0.0), (3.0, 0.0)), [True, False]).life.number.tolist() == [3, 6]


def test_only_one_new_person_gets_the_number_of_somebody_lost() -> None:
    lost_one = replace(lost((0.0, 0.0)), time=np.array([SECOND // 2]))
    first = confirm(replace(people([0], (0.2, 0.0)), lost=lost_one), [False])
    assert (first.life.number.tolist(), len(first.lost)) == ([1], 0)
    both = confirm(replace(people([0, 0], (0.6, 0.0), (0.2, 0.0)), lost=lost_one), [False, False])
    assert both.life.number.tolist() == [6, 1]
    late = replace(people([0], (0.2, 0.0)), time=3 * SECOND, lost=lost_one)
    assert confirm(late, [False]).life.number.tolist() == [6]
