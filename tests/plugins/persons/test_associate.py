"""People in 3D from what networks find in several cameras: identities, places, headings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.crowded import corner_room, crowded, followed, table
from tests.travelled import travelled

from followspot import Context
from followspot.errors import FollowspotError
from followspot.messages import identical
from followspot.people import Boxes
from followspot.points import Points2D
from followspot.tracking import PREDICTED
from followspot_accuracy import score_persons
from followspot_persons.associate.stage import Associate


def test_joints_of_four_cameras_become_people_with_places_headings_and_one_number_each() -> None:
    room, sets, truth = crowded(people=4, frames=40, fps=10, seed=3)
    out = followed(room, sets, "points")
    score = score_persons(table(sets, out), truth)
    one, whole = score.tracking, score.overall
    assert (one.switches, one.false) == (0, 0)
    assert one.mota > 0.97
    assert one.mean_m < 0.03
    assert abs(whole.height_cm.mean) < 5
    assert whole.torso.median_deg < 6
    assert whole.pan_median_deg < 12
    assert whole.tilt_median_deg < 12


def test_cameras_that_are_half_a_frame_out_of_step_keep_the_identities() -> None:
    room, sets, truth = crowded(people=4, frames=24, fps=4, seed=5, late=(0.0, 0.12, 0.06, 0.12))
    for kind, mean in (("points", 0.08), ("boxes", 0.12)):
        one = score_persons(table(sets, followed(room, sets, kind, delay_sigma=0.06)), truth).tracking
        assert one.switches == 0, kind
        assert one.mota > 0.9, kind
        assert one.mean_m < mean, kind


@pytest.mark.parametrize(
    ("fps", "frames", "late"), [(4, 24, (0.0, 0.12, 0.06, 0.12)), (20, 80, (0.0, 0.12, 0.0, 0.06))]
)
def test_known_delays_of_cameras_are_no_error(fps: int, frames: int, late: tuple[float, ...]) -> None:
    """At 20 pictures a second they are longer than the time from one picture to the next."""
    room, sets, truth = crowded(people=2, frames=frames, fps=fps, seed=6, late=late)
    cameras = {
        name: replace(camera, clock_offset=by)
        for (name, camera), by in zip(room.cameras.items(), late, strict=True)
    }
    guessed = score_persons(table(sets, followed(room, sets, "points")), truth).tracking
    known_room = replace(room, cameras=cameras)
    known = score_persons(table(sets, followed(known_room, sets, "points")), truth).tracking
    assert known.mean_m < 0.03
    assert known.mean_m < 0.5 * guessed.mean_m


def test_boxes_of_four_cameras_become_people_on_the_floor() -> None:
    room, sets, truth = crowded(people=3, frames=40, fps=10, seed=4)
    score = score_persons(table(sets, followed(room, sets, "boxes")), truth)
    assert score.tracking.switches == 0
    assert score.tracking.mota > 0.95
    assert score.tracking.mean_m < 0.08
    assert abs(score.overall.height_cm.mean) < 5


def test_skeletons_have_joints_with_names_places_and_honest_covariances() -> None:
    room, sets, _ = crowded(people=4, frames=40, fps=10, seed=3)
    out = followed(room, sets, "points")[-1]
    skeletons = out.skeletons
    assert set(skeletons.person) == set(out.poses.person)
    left, right = (
        skeletons.where(skeletons.label == skeletons.labels.index(name)) for name in ("left_hip", "right_hip")
    )
    apart = np.linalg.norm(left.xyz - right.xyz, axis=1)
    assert (np.abs(apart - 0.18) < 0.08).all()
    sigma = np.sqrt(np.linalg.eigvalsh(skeletons.covariance)[:, -1])
    assert (sigma <= 0.15).all()
    assert 0.005 < np.median(sigma) < 0.04


def test_a_person_whom_nobody_detects_coasts_is_marked_and_ends() -> None:
    room, sets, _ = crowded(people=2, frames=40, fps=10, seed=7)
    blind = [tuple((p.where(slice(0)), b.where(slice(0))) for p, b in each) for each in sets[20:]]
    for each, seen in zip(blind, sets[20:], strict=True):
        for (points, boxes), (old, _) in zip(each, seen, strict=True):
            points.__dict__["header"] = boxes.__dict__["header"] = old.header
    out = followed(room, sets[:20] + blind, "points", maximum_missed_time=0.5)
    assert (out[20].poses.state == PREDICTED).all()
    assert len(out[20].poses.person) == 2
    assert [len(each.poses.person) for each in out[26:]] == [0] * 14


def test_nobody_appears_where_one_camera_alone_sees_somebody() -> None:
    room, sets, _ = crowded(people=2, frames=10, fps=10, seed=7)
    out = followed(room, [each[:1] for each in sets], "points")
    assert all(len(each.poses.person) == 0 for each in out)


@pytest.mark.parametrize("kind", ["points", "boxes"])
def test_cameras_that_send_nothing_keep_nobody_from_being_found(kind: str) -> None:
    room, sets, _ = crowded(people=4, frames=40, fps=10, seed=3)
    two = [each[:2] for each in sets]
    names = tuple(room.cameras)
    alone = replace(room, cameras={name: room.cameras[name] for name in names[:2]})
    with_others, without = followed(room, two, kind), followed(alone, two, kind)
    assert max(len(out.poses.person) for out in without) >= 3
    assert [len(out.poses.person) for out in with_others] == [len(out.poses.person) for out in without]


def test_people_outside_the_area_are_not_sought() -> None:
    room, sets, _ = crowded(people=2, frames=10, fps=10, seed=7)
    out = followed(room, sets, "points", area=(10.0, 10.0, 11.0, 11.0))
    assert all(len(each.poses.person) == 0 for each in out)


def test_joints_whose_names_tell_no_heading_are_warned_of_once() -> None:
    room, sets, _ = crowded(people=2, frames=10, fps=10, seed=7)
    for named, told in ((lambda name: name.replace("_", "."), 1), (str, 0)):
        warnings: list[str] = []
        stage = Associate(Context("associate", room, receives=(Points2D,), warn=warnings.append))
        stage.setup()
        for each in sets:
            renamed = [replace(points, labels=tuple(map(named, points.labels))) for points, _ in each]
            for points, (old, _) in zip(renamed, each, strict=True):
                points.__dict__["header"] = old.header
            stage.process(points=renamed)
        assert len(warnings) == told
        assert all("left_shoulder" in text for text in warnings)


@pytest.mark.parametrize(("scale", "told"), [(0.5, True), (1.0, False)])
def test_joints_of_pictures_of_half_the_size_are_warned_of_at_the_end(scale: float, told: bool) -> None:
    room, sets, _ = crowded(people=2, frames=20, fps=10, seed=7)
    warnings: list[str] = []
    stage = Associate(Context("associate", room, receives=(Points2D,), warn=warnings.append))
    stage.setup()
    for each in sets:
        scaled = [replace(points, pixel=scale * points.pixel, xy=scale * points.xy) for points, _ in each]
        for points, (old, _) in zip(scaled, each, strict=True):
            points.__dict__["header"] = old.header
        stage.process(points=scaled)
    stage.close()
    assert len(warnings) == told
    assert all("upper left quarter" in text and "smaller pictures" in text for text in warnings)


def test_joints_and_boxes_at_once_are_refused() -> None:
    stage = Associate(Context("associate", corner_room(), receives=(Points2D, Boxes)))
    with pytest.raises(FollowspotError, match="points or boxes"):
        stage.setup()


def test_a_camera_that_misses_somebody_for_a_moment_ends_nobody() -> None:
    """At 60 pictures a second a network misses the same person in many pictures in a row."""
    room, sets, _ = crowded(people=2, frames=40, fps=60, seed=3)
    pairs = [each[:2] for each in sets]
    before = followed(room, pairs[:14], "points")[-1].poses.person.tolist()
    for frame in range(14, 24):
        (seen, boxes), (missed, _) = pairs[frame]
        blind = missed.where(slice(0))
        blind.__dict__["header"] = missed.header
        pairs[frame] = ((seen, boxes), (blind, boxes))
    found = [each.poses.person.tolist() for each in followed(room, pairs, "points")[14:]]
    assert len(before) == 2
    assert found == [before] * len(found)


@pytest.mark.parametrize("kind", ["points", "boxes"])
def test_a_successor_carries_on_with_the_same_people(kind) -> None:
    room, sets, _ = crowded(people=3, frames=24, fps=10, seed=4)
    expected = followed(room, sets, kind)[12:]
    first, second = (Associate(Context("associate", room)) for _ in range(2))
    for stage in (first, second):
        stage.setup()
    found = []
    for number, each in enumerate(sets):
        if number == 12:
            second.restore(travelled(first.state()))
        stage = first if number < 12 else second
        found.append(stage.process(**{kind: tuple(one[kind == "boxes"] for one in each)}))
    for told, wanted in zip(found[12:], expected, strict=True):
        assert len(told.poses.person)
        assert identical(told.poses, wanted.poses)
        assert identical(told.skeletons, wanted.skeletons)


@pytest.mark.parametrize("kind", ["points", "boxes"])
@pytest.mark.parametrize("off", [0.0, 3.0])
def test_a_camera_that_is_said_to_stand_elsewhere_is_warned_of_at_the_end(kind: str, off: float) -> None:
    room, sets, _ = crowded(people=4, frames=40, fps=10, seed=3)
    name = list(room.cameras)[1]
    camera = room.cameras[name]
    moved = replace(camera, translation=camera.translation + camera.rotation @ np.array([0.0, off, 0.0]))
    warnings: list[str] = []
    context = Context(
        "associate",
        replace(room, cameras={**room.cameras, name: moved}),
        receives=(Points2D if kind == "points" else Boxes,),
        warn=warnings.append,
    )
    stage = Associate(context)
    stage.setup()
    for each in sets:
        found = tuple(one[kind == "boxes"] for one in each)
        stage.process(**{kind: found})
    stage.close()
    assert len(warnings) == (off > 0)
    assert all(f"what {name} (" in text and "calibrate check" in text for text in warnings)
