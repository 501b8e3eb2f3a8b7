"""Lengths of arms and legs: learnt from both sides, and kept by the joints that are reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.crowded import crowded, followed
from tests.plugins.persons.joint_tracks import LEFT, RIGHT, bodies

from followspot.people import Skeletons
from followspot_persons.associate.joints.limbs import SPREAD, USUAL, Lengths, constrained, learnt
from followspot_persons.associate.joints.tracks import JointTracks
from followspot_sim.actor.landmarks import NAMES

RNG = np.random.default_rng(4)
LIMBS = (("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle"))


def lengths_of(tracks: JointTracks, side: str) -> list[float]:
    ends = [[tracks.xyz[0, NAMES.index(f"{side}_{name}")] for name in limb] for limb in LIMBS]
    return [float(np.linalg.norm(a - b)) for a, b in ends]


def test_a_length_is_learnt_from_both_sides_and_the_surer_side_counts_more() -> None:
    known = Lengths.none().of(np.array([7]))
    np.testing.assert_allclose(known.mean[0], USUAL)
    both = bodies(0.02)
    place = both.position_covariance.copy()
    place[0, NAMES.index("right_elbow")] *= 25
    unequal = replace(both, position_covariance=place)
    for _ in range(300):
        known, other = (learnt(known, NAMES, body) for body in (both, both))
    assert known.mean[0, 0, 0] == pytest.approx((LEFT + RIGHT) / 2, abs=0.004)
    assert known.variance[0, 0, 0] < (0.3 * SPREAD * USUAL[0, 0]) ** 2
    other = Lengths.none().of(np.array([7]))
    for _ in range(300):
        other = learnt(other, NAMES, unequal)
    assert other.mean[0, 0, 0] > known.mean[0, 0, 0] + 0.005


def test_one_camera_teaches_no_length_and_a_picture_little() -> None:
    known = Lengths.none().of(np.array([7]))
    one = learnt(known, NAMES, bodies(0.02, views=1))
    np.testing.assert_array_equal(one.mean, known.mean)
    step = learnt(known, NAMES, bodies(0.02)).mean[0, 0, 0] - known.mean[0, 0, 0]
    assert abs(step) < 0.2 * abs((LEFT + RIGHT) / 2 - USUAL[0, 0])


def test_lengths_belong_to_numbers_and_not_to_who_has_none_yet() -> None:
    known = Lengths(np.array([3, 0]), np.full((2, 2, 2), 0.5), np.full((2, 2, 2), 1e-6))
    again = known.of(np.array([0, 4, 3]))
    np.testing.assert_allclose(again.mean[:, 0, 0], [USUAL[0, 0], USUAL[0, 0], 0.5])
    assert again.number.tolist() == [0, 4, 3]


def test_joints_move_by_their_covariance_until_limbs_have_their_lengths() -> None:
    given = bodies(0.03)
    place = given.position_covariance.copy()
    place[0, NAMES.index("right_shoulder")] /= 100
    given = replace(given, position_covariance=place)
    known = Lengths(np.array([1]), np.array([[[0.30, 0.25], [0.42, 0.42]]]), np.full((1, 2, 2), 1e-6))
    found = constrained(known, NAMES, given)
    for side in ("left", "right"):
        np.testing.assert_allclose(lengths_of(found, side), [0.30, 0.25, 0.42, 0.42], atol=0.003)
    moved = np.linalg.norm(found.xyz - given.xyz, axis=-1)[0]
    assert moved[NAMES.index("right_shoulder")] < 0.1 * moved[NAMES.index("right_elbow")]
    np.testing.assert_array_equal(found.xyz[0, NAMES.index("nose")], given.xyz[0, NAMES.index("nose")])
    elbow = found.position_covariance[0, NAMES.index("left_elbow")]
    assert elbow[2, 2] < 0.8 * 0.03**2  # surer along the arm
    assert elbow[0, 0] == pytest.approx(0.03**2)  # and not across


def test_joints_that_are_nowhere_near_are_left_alone() -> None:
    known = Lengths.none().of(np.array([1]))
    far = bodies(0.2)
    np.testing.assert_array_equal(constrained(known, NAMES, far).xyz, far.xyz)
    unseen = replace(bodies(0.02), known=np.zeros((1, len(NAMES)), bool))
    np.testing.assert_array_equal(constrained(known, NAMES, unseen).xyz, unseen.xyz)
    other = ("head", "hand")
    assert constrained(known, other, unseen) is unseen
    assert learnt(known, other, unseen) is known


def ratios(skeletons: list[Skeletons]) -> np.ndarray:
    """Left over right, of each limb of each person in each set."""
    found = []
    for one in skeletons:
        at = {(p, one.labels[j]): x for p, j, x in zip(one.person.tolist(), one.label, one.xyz, strict=True)}
        for person in set(one.person.tolist()):
            for limb in LIMBS:
                ends = [[at.get((person, f"{side}_{j}")) for j in limb] for side in ("left", "right")]
                if all(end is not None for side in ends for end in side):
                    left, right = (np.linalg.norm(a - b) for a, b in ends)
                    found.append(left / right)
    return np.array(found)


def test_left_and_right_limbs_of_people_are_equal() -> None:
    room, sets, _ = crowded(people=4, frames=40, fps=10, seed=3)
    found = ratios([each.skeletons for each in followed(room, sets, "points")][10:])
    assert len(found) > 300
    assert abs(np.median(found) - 1) < 0.005
    assert np.quantile(np.abs(found - 1), 0.9) < 0.02
