"""The steady motion of targets, against what the filter's equations say of simple motions."""

from __future__ import annotations

import numpy as np
import pytest

from followspot.messages import Array
from followspot_balls.single_view.steady_motion import SETTLING, SteadyMotion

BOTH = np.ones(2, bool)
ALL = slice(None)


def updated(paths: Array, seconds: float) -> SteadyMotion:
    """The motion of two targets after their positions (F, 2, 3) m."""
    motion = SteadyMotion.unknown(2)
    for places in paths:
        motion = motion.updated(places, BOTH, seconds)
    return motion


@pytest.mark.parametrize("seconds", [1 / 60, 1 / 20])
def test_a_steady_motion_is_learnt_and_an_acceleration_deviates_from_it(seconds: float) -> None:
    time = np.arange(round(3.0 / seconds)) * seconds
    steady, faster = np.outer(time, [1.0, -2.0, 0.0]), np.outer(time**2 / 2, [3.0, 0.0, 0.0])
    paths = np.stack([steady, faster], axis=1)
    motion = updated(paths[:-1], seconds)
    deviation = np.linalg.norm(motion.deviation(paths[-1], ALL, seconds), axis=1)
    assert deviation[0] < 1e-4
    behind = 3.0 * seconds**2 / (1 - np.exp(-seconds / SETTLING)) ** 2  # a T^2 / beta, of the g-h filter
    assert deviation[1] == pytest.approx(behind, rel=0.01)


def test_a_target_that_is_not_tracked_has_no_steady_motion() -> None:
    motion = updated(np.zeros((5, 2, 3)), 0.1).updated(np.zeros((2, 3)), np.array([True, False]), 0.1)
    assert motion.deviation(np.ones((2, 3)), ALL, 0.1).tolist() == [[1.0] * 3, [0.0] * 3]
    begun = motion.updated(np.ones((2, 3)), BOTH, 0.1)
    assert begun.xyz[1].tolist() == [1.0] * 3
    assert begun.velocity[1].tolist() == [0.0] * 3


def test_two_frames_of_one_time_leave_the_velocity_as_it_is() -> None:
    motion = updated(np.outer(np.arange(5) * 0.1, [1.0, 0.0, 0.0])[:, None].repeat(2, axis=1), 0.1)
    with np.errstate(all="raise"):
        again = motion.updated(motion.xyz, BOTH, 0.0)
    np.testing.assert_array_equal(again.velocity, motion.velocity)
