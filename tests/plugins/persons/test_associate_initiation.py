"""How soon new people get a number, and what makes nobody."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.plugins.persons.box_bodies import standing
from tests.plugins.persons.crowded import corner_room
from tests.plugins.persons.false_boxes import person, sent

from followspot import Context
from followspot.messages import Header, stamped
from followspot.points import Points2D
from followspot.room import Member
from followspot_persons.associate.boxes.ellipsoid import boxes_of
from followspot_persons.associate.boxes.model import BoxModel
from followspot_persons.associate.boxes.standing import standing_ratios
from followspot_persons.associate.colors.torso_colors import BINS
from followspot_persons.associate.colors.track_colors import unknown_colors
from followspot_persons.associate.detections import Detections
from followspot_persons.associate.existence import ExistenceEvidence
from followspot_persons.associate.joints.agreement import agreement
from followspot_persons.associate.multi_view.views import Noise, images, views_of
from followspot_persons.associate.stage import Associate
from followspot_persons.associate.tracks.camera_association import Association, associated
from followspot_persons.associate.tracks.lost_people import LostPeople
from followspot_persons.associate.tracks.tracks import LifeCycles, Tracks
from followspot_sim.actor.points import PersonPoints

FPS = 10
VIEWS = views_of(tuple(corner_room().cameras.values()))


def detections(cameras: int, seed: int = 1, **network: Any) -> list[tuple[Points2D, ...]]:
    """What the first cameras find of one person, or of false ones, in each set. network: its mistakes."""
    room, found = corner_room(), []
    for name in list(room.cameras)[:cameras]:
        stage = PersonPoints(
            Context(name, room, Member("cameras", name)),
            people=1,
            frames=30,
            fps=FPS,
            seed=seed,
            walking_area=(-1, -1, 1, 1),
            **network,
        )
        stage.setup()
        found.append([each.points for each in stage.process()])
    return [
        tuple(stamped(replace(one), Header("n", frame, frame * 10**9 // FPS)) for one in each)
        for frame, each in enumerate(zip(*found, strict=True))
    ]


def people(sets: list[tuple[Points2D, ...]]) -> list[int]:
    """Number of people after each set."""
    stage = Associate(Context("associate", corner_room()))
    stage.setup()
    return [len(stage.process(points=one).poses.person) for one in sets]


def doubled(points: Points2D) -> Points2D:
    """What a network finds if it takes the upper half of a person for another one."""
    again = points.where(points.label < 11)
    again = replace(again, instance=again.instance + 1)
    both = {
        name: np.concatenate([getattr(one, name) for one in (points, again)]) for name in points.array_names
    }
    return stamped(replace(points, **both), points.header)


def only(points: Points2D, joints: int, names: int) -> Points2D:
    """The first joints of a person alone, of a network that knows as many names."""
    kept = points.where(points.label < joints)
    return stamped(replace(kept, labels=points.labels[:names]), points.header)


@pytest.mark.parametrize(("joints", "names", "first"), [(17, 17, 1), (9, 17, 0), (9, 9, 1)])
def test_two_cameras_report_somebody_at_once_if_most_joints_agree(
    joints: int, names: int, first: int
) -> None:
    """Few joints of many may agree by chance, and wait for the next set."""
    sets = detections(2, clutter=0.0, joint_miss=0.0, person_miss=0.0)
    found = people([tuple(only(one, joints, names) for one in each) for each in sets[:3]])
    assert found == [first, 1, 1]


def test_joints_that_disagree_count_against_those_that_agree() -> None:
    rng = np.random.default_rng(1)
    xyz = rng.uniform([-0.3, -0.3, 0.1], [0.3, 0.3, 1.8], (17, 3))
    noise, both = Noise(2.0, 0.03, 0.0), np.arange(2)
    xy = np.array([images(view.projection, xyz)[0] for view in VIEWS.each[:2]])
    assert agreement(VIEWS, both, xy, xyz, noise) == 17
    far = xy.copy()
    far[1, :5] += 60.0
    assert agreement(VIEWS, both, far, xyz, noise) == 12 - 5
    far[1, 5:8] = np.nan  # one camera alone tells nothing of these
    assert agreement(VIEWS, both, far, xyz, noise) == 9 - 5


def test_false_people_of_two_networks_agree_about_too_few_joints() -> None:
    found = [people(detections(2, seed, clutter=5.0, person_miss=1.0)) for seed in range(1, 7)]
    assert np.mean(found) < 0.03


def test_half_of_a_person_that_is_found_again_is_nobody_else() -> None:
    sets = detections(4, clutter=0.0, joint_miss=0.0, person_miss=0.0)
    assert people([tuple(map(doubled, each)) for each in sets]) == [1] * len(sets)


@pytest.mark.parametrize(("cameras", "false", "first"), [(2, 0, 0), (3, 0, 1), (3, 12, 0)])
def test_three_cameras_report_somebody_in_boxes_at_once_unless_many_boxes_are_false(
    cameras: int, false: int, first: int
) -> None:
    rng, stage = np.random.default_rng(5), Associate(Context("associate", corner_room()))
    stage.setup()
    sets = [sent([person((0.2, 0.1))], false, time, rng)[:cameras] for time in (0.0, 0.25, 0.5)]
    found = [len(stage.process(boxes=one).poses.person) for one in sets]
    assert (found[0], found[2]) == (first, 1)


def test_a_box_that_fits_a_person_badly_may_be_of_somebody_else() -> None:
    """A box that fits well is taken for a second one of the same person."""
    model, body, view = BoxModel(0.01, np.array([0.0, 0.0, 1.0, 0.0])), standing((0.0, 0.0)), VIEWS.each[0]
    life = LifeCycles(np.array([1]), np.full(1, 8.0), np.zeros(1, int), unknown_colors(1, 4))
    tracks = Tracks(body, life, 0, 1, np.zeros((4, 2), int), LostPeople.none(4))
    own = boxes_of(view, body.likeliest)[0]
    box = np.concatenate([own, own + 0.25 * (own[:, 3] - own[:, 1]) * np.array([1.0, 0.0, 1.0, 0.0])])
    well, badly = model.log_ratios(body, view, box)[0]
    assert well > 6 > 3 > badly > 0
    given = Detections(0, 0, box, np.full((2, BINS), np.nan))
    none = np.zeros(0, int)
    _, found = associated(tracks, model, view, Association.none(given, 1), lambda _: (none, none))
    assert found.explained.tolist() == [True, False]


@pytest.mark.parametrize(
    ("views", "loss", "missed"), [(0, 0.0, True), (1, -2.0, False), (1, -4.6, True), (2, -4.6, False)]
)
def test_one_camera_alone_shows_nobody_whom_two_others_should_see(
    views: int, loss: float, missed: bool
) -> None:
    evidence = ExistenceEvidence(np.zeros(1), np.array([loss]), np.array([views]))
    assert evidence.missed.tolist() == [missed]


def test_boxes_whose_ends_meet_at_head_and_feet_are_sooner_one_person() -> None:
    """Of somebody in the air neither end is where a standing person's is; a hidden end tells nothing."""
    floor, both = np.array([0.0, 0.0, 1.0, 0.0]), np.arange(2)
    first, second = np.array([0]), np.array([1])

    def ratio(low: float, high: float) -> float:
        xyz = np.array([[0.1, 0.2, high], [0.1, 0.2, low]])
        ends = np.array([images(view.projection, xyz)[0] for view in VIEWS.each[:2]])
        up, down = (standing_ratios(VIEWS, both, ends, side, first, second)[0] for side in (floor, -floor))
        assert up == down
        return float(up)

    assert ratio(0.0, 1.72) > 6 > ratio(0.0, 1.0) > 0 > ratio(0.9, 2.6)
    ends = np.full((2, 2, 2), np.nan)
    assert standing_ratios(VIEWS, both, ends, floor, first, second)[0] == 0
