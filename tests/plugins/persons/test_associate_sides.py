"""Left and right of people stay right where a network exchanges them, and real turns are followed."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.plugins.persons.crowded import Set, crowded, followed, table

from followspot import Room
from followspot.messages import Header, stamped
from followspot.points import Points2D
from followspot_accuracy import PoseTruthTable
from followspot_persons.associate.joints.sides import (
    PARTS,
    SHARE,
    SURE,
    observed,
    predicted,
    sides_of,
    unknown,
)
from followspot_persons.associate.stage import Outputs
from followspot_persons.pose_net.blazepose import BlazePose
from followspot_sim.actor.landmarks import NAMES

FPS, FRAMES = 25, 60
WHOLE = ("eye", "ear", "shoulder", "elbow", "wrist", "hip", "knee", "ankle")
HEAD = ("nose", "left_eye", "right_eye", "left_ear", "right_ear")


def exchanged(
    sets: list[Set], cameras: tuple[int, ...], joints: tuple[str, ...], first: int, end: int
) -> list[Set]:
    """The sets, of which in those from first to end these cameras name these joints by the other side."""
    sides = sides_of(NAMES)
    moved = np.array([name.partition("_")[2] in joints for name in NAMES])
    label = np.where(moved, sides.mirror, np.arange(len(NAMES))).astype(np.int32)
    found = []
    for number, each in enumerate(sets):
        if first <= number < end:
            each = tuple(
                (_again(points, label=label[points.label]) if camera in cameras else points, boxes)
                for camera, (points, boxes) in enumerate(each)
            )
        found.append(each)
    return found


def without_heads(sets: list[Set]) -> list[Set]:
    """The sets without the joints of heads."""
    found = []
    for each in sets:
        bodies = []
        for points, boxes in each:
            kept = ~np.isin(points.label, [NAMES.index(name) for name in HEAD])
            names = ("label", "instance", "pixel", "xy", "score")
            bodies.append((_again(points, **{name: getattr(points, name)[kept] for name in names}), boxes))
        found.append(tuple(bodies))
    return found


def _again(points: Points2D, **values: np.ndarray) -> Points2D:
    return stamped(replace(points, **values), points.header)


def joints_of(outputs: list[Outputs]) -> dict[tuple[int, int, str], np.ndarray]:
    """Places of arms, legs and trunks, m, by set, person and joint."""
    found = {}
    for number, each in enumerate(outputs):
        s = each.skeletons
        for person, label, xyz in zip(s.person.tolist(), s.label, s.xyz, strict=True):
            if s.labels[label] not in HEAD:
                found[number, person, s.labels[label]] = xyz
    return found


@cache
def three(heads: bool) -> tuple[Room, list[Set], dict[tuple[int, int, str], np.ndarray]]:
    """A room, what networks find of three people in it, and where the association then sees their joints."""
    room, sets, _ = crowded(people=3, frames=FRAMES, fps=FPS, seed=3)
    sets = sets if heads else without_heads(sets)
    return room, sets, joints_of(followed(room, sets, "points"))


def heading_errors(sets: list[Set], outputs: list[Outputs], truth: PoseTruthTable) -> list[np.ndarray]:
    """Angles between the chest of each tracked person and that of the nearest true one, rad."""
    poses, errors = table(sets, outputs), []
    for number, each in enumerate(sets):
        now = poses.time == each[0][0].header.time / 1e9
        found, true = poses.pose[now], truth.pose[number]
        near = np.linalg.norm(found[:, None, :2] - true[None, :, :2], axis=2).argmin(axis=1)
        apart = found[:, 3] - true[near, 3]
        errors.append(np.abs(np.arctan2(np.sin(apart), np.cos(apart))))
    return errors


@pytest.mark.parametrize(
    ("cameras", "joints", "seconds"),
    [
        ((0, 1), WHOLE, 1.0),
        ((2, 3), ("knee", "ankle"), 1.0),
        ((0, 1, 2), WHOLE, 0.5),
        pytest.param((1,), WHOLE, 1.0, marks=pytest.mark.thorough),
        pytest.param((0, 2), ("shoulder", "elbow", "wrist"), 1.0, marks=pytest.mark.thorough),
        pytest.param((0, 1), ("elbow", "wrist"), 1.0, marks=pytest.mark.thorough),
        pytest.param((1, 2, 3), ("hip", "knee", "ankle"), 0.5, marks=pytest.mark.thorough),
    ],
)
@pytest.mark.parametrize("heads", [True, False])
def test_an_exchange_in_some_cameras_moves_no_joint(
    cameras: tuple[int, ...], joints: tuple[str, ...], seconds: float, heads: bool
) -> None:
    room, sets, right = three(heads)
    found = joints_of(
        followed(room, exchanged(sets, cameras, joints, 25, 25 + round(seconds * FPS)), "points")
    )
    moved = [np.linalg.norm(found[key] - right[key]) for key in right.keys() & found.keys()]
    assert len(moved) > 0.98 * len(right)
    assert np.mean(np.array(moved) > 0.1) < 0.005


@pytest.mark.parametrize(
    ("cameras", "seconds", "most"), [((0, 1), 1.0, 0.05), ((0, 2), 1.0, 0.15), ((0, 1, 2), 0.5, 0.25)]
)
def test_people_who_are_first_seen_with_sides_exchanged_are_righted_by_their_faces(
    cameras: tuple[int, ...], seconds: float, most: float
) -> None:
    room, sets, truth = crowded(people=3, frames=FRAMES, fps=FPS, seed=3)
    wrong = exchanged(sets, cameras, WHOLE, 0, round(seconds * FPS))
    errors = heading_errors(wrong, followed(room, wrong, "points"), truth)
    assert np.mean(np.concatenate(errors) > np.pi / 2) < most
    assert np.concatenate(errors[round((seconds + 0.5) * FPS) :]).max() < np.pi / 2


def test_a_body_without_a_face_is_righted_by_the_labels_over_time() -> None:
    room, sets, truth = crowded(people=3, frames=FRAMES, fps=FPS, seed=3)
    wrong = exchanged(without_heads(sets), (0, 1, 2, 3), WHOLE, 0, 13)
    errors = heading_errors(wrong, followed(room, wrong, "points"), truth)
    assert np.median(np.concatenate(errors[:13])) > 0.8 * np.pi  # all that is known is wrong
    assert np.concatenate(errors[13 + FPS :]).max() < np.pi / 2


def test_people_who_turn_quickly_are_followed() -> None:
    """Three times as fast as they walk and turn, by sets that leave out two of three."""
    room, sets, truth = crowded(people=3, frames=90, fps=FPS, seed=6)
    quick = [
        tuple((stamped(points, Header("network", k, round(k * 1e9 / FPS))), boxes) for points, boxes in each)
        for k, each in enumerate(sets[::3])
    ]
    turning = np.diff(np.unwrap(truth.pose[::3, :, 3], axis=0), axis=0)
    assert np.abs(turning).max() * FPS > 2 * np.pi  # a turn in less than a second
    every_third = replace(truth, pose=truth.pose[::3])
    errors = heading_errors(quick, followed(room, quick, "points"), every_third)
    assert np.concatenate(errors).max() < np.pi / 2


def odds_after(ratios: list[float], pictures: int) -> tuple[np.ndarray, np.ndarray]:
    """Log-odds after pictures that tell the same, of one camera for each ratio, 25 pictures a second."""
    exchanged, reversal = unknown(1, len(ratios))
    for _ in range(pictures):
        exchanged = predicted(exchanged, 1 / FPS)
        for camera, ratio in enumerate(ratios):
            told = np.full((1, len(PARTS)), ratio)
            exchanged[:, camera], reversal = observed(exchanged[:, camera], reversal, told)
    return exchanged[0, :, 0, 0], reversal[0]


def test_cameras_that_agree_for_seconds_outvote_the_tracked_sides_and_half_of_them_do_not() -> None:
    assert odds_after([20.0] * 3, 10)[1].min() > 3
    assert odds_after([-20.0] * 3, 10)[1].max() < -3
    exchanged, reversal = odds_after([20.0, 20.0, -20.0, -20.0], 50)
    assert np.abs(reversal).max() < 1e-6
    assert np.sign(exchanged).tolist() == [1, 1, -1, -1]
    assert odds_after([20.0, -20.0, -20.0, -20.0], 50)[1].max() < -3


def test_pictures_that_tell_nothing_leave_what_is_usual() -> None:
    usual = np.log(SHARE / (1 - SHARE))
    exchanged, reversal = odds_after([0.0], 50)
    assert exchanged[0] == pytest.approx(usual)
    assert reversal == pytest.approx(0)
    assert predicted(np.array([SURE, -SURE]), 10.0) == pytest.approx(usual, abs=1e-3)


def test_joints_have_another_side_only_if_both_are_named() -> None:
    sides = sides_of(("nose", "left_hip", "right_hip", "left_knee", "right_big_toe", "left_big_toe", "left"))
    assert sides.mirror.tolist() == [0, 2, 1, 3, 5, 4, 6]
    assert sides.part.sum(axis=1).tolist() == [0, 1, 1, 0, 1, 1, 0]
    assert sides.left.tolist() == [0, 1, 0, 0, 0, 1, 0]


def test_fingers_belong_to_arms_and_toes_to_legs() -> None:
    part = sides_of(BlazePose.joints).part
    arms, legs = 2, 4
    assert {BlazePose.joints[row] for row in np.flatnonzero(part[:, arms])} == {
        f"{side}_{name}"
        for side in ("left", "right")
        for name in ("elbow", "wrist", "pinky", "index", "thumb")
    }
    assert {BlazePose.joints[row] for row in np.flatnonzero(part[:, legs])} == {
        f"{side}_{name}" for side in ("left", "right") for name in ("knee", "ankle", "heel", "foot_index")
    }
