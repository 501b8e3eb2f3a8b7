"""The steady course of targets, against what the filter's equations say of simple motions."""

from __future__ import annotations

import numpy as np
import pytest

from followspot.messages import Array
from followspot_balls.single_view.course import SETTLING, Course

BOTH = np.ones(2, bool)
ALL = slice(None)


def followed(paths: Array, seconds: float) -> Course:
    """The course of two targets after their places (F, 2, 3) m."""
    course = Course.unknown(2)
    for places in paths:
        course = course.followed(places, BOTH, seconds)
    return course


@pytest.mark.parametrize("seconds", [1 / 60, 1 / 20])
def test_a_steady_motion_is_the_course_and_an_acceleration_strays_from_it(seconds: float) -> None:
    time = np.arange(round(3.0 / seconds)) * seconds
    steady, faster = np.outer(time, [1.0, -2.0, 0.0]), np.outer(time**2 / 2, [3.0, 0.0, 0.0])
    paths = np.stack([steady, faster], axis=1)
    course = followed(paths[:-1], seconds)
    stray = np.linalg.norm(course.stray(paths[-1], ALL, seconds), axis=1)
    assert stray[0] < 1e-4
    behind = 3.0 * seconds**2 / (1 - np.exp(-seconds / SETTLING)) ** 2  # a T^2 / beta, of the g-h filter
    assert stray[1] == pytest.approx(behind, rel=0.01)


def test_a_target_that_is_not_tracked_has_no_course() -> None:
    course = followed(np.zeros((5, 2, 3)), 0.1).followed(np.zeros((2, 3)), np.array([True, False]), 0.1)
    assert course.stray(np.ones((2, 3)), ALL, 0.1).tolist() == [[1.0] * 3, [0.0] * 3]
    begun = course.followed(np.ones((2, 3)), BOTH, 0.1)
    assert begun.place[1].tolist() == [1.0] * 3
    assert begun.velocity[1].tolist() == [0.0] * 3


def test_two_frames_of_one_time_leave_the_velocity_as_it_is() -> None:
    course = followed(np.outer(np.arange(5) * 0.1, [1.0, 0.0, 0.0])[:, None].repeat(2, axis=1), 0.1)
    with np.errstate(all="raise"):
        again = course.followed(course.place, BOTH, 0.0)
    np.testing.assert_array_equal(again.velocity, course.velocity)
