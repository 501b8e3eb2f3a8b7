"""Where the bundle begins: where all views make the ball likeliest, though each shows a fragment of it."""

from __future__ import annotations

import numpy as np
from tests.plugins.balls.scene import forecast_at, unweighed
from tests.plugins.balls.test_bundle import HIGH, bundle, candidates, undistorted, whole

from followspot.messages import Array
from followspot.tracking import Candidates

RIVAL = (0.1, 0.1, 1.5)
"""A place 30 cm from the ball."""
ELSEWHERE = (1.5, 1.5, 1.0)
OFF = np.array([[0.8, 0.6], [-0.6, 0.8], [0.8, -0.6], [-0.8, -0.6]])
"""Errors of the centres of fragments, px: each is one pixel off."""


def fragments_and_rival(share: float, fragments: int = 4) -> Candidates:
    """A fifth of a ball in some views, and this share of something in two of them that agree exactly."""
    ball, rival = np.array(HIGH), np.array(RIVAL)
    xy: list[Array] = list((undistorted(ball) + OFF)[:, None])
    area: list[Array] = list((0.2 * whole(ball))[:, None])
    xy[fragments:] = [np.zeros((0, 2))] * (4 - fragments)
    area[fragments:] = [np.zeros(0)] * (4 - fragments)
    for view in (0, 1):
        xy[view] = np.vstack([xy[view], undistorted(rival)[view]])
        area[view] = np.append(area[view], share * whole(rival)[view])
    return candidates(xy, area, [[[True, False]] * len(points) for points in xy])


def test_four_fragments_outvote_two_larger_blobs_elsewhere() -> None:
    found = unweighed(bundle()).process(fragments_and_rival(0.5), None)
    assert np.linalg.norm(found.xyz[0] - HIGH) < 0.02
    assert found.support[0] == 6


def test_whole_balls_outvote_as_many_fragments() -> None:
    found = unweighed(bundle()).process(fragments_and_rival(1.0, fragments=2), None)
    assert np.linalg.norm(found.xyz[0] - RIVAL) < 0.01


def test_four_fragments_outvote_two_larger_blobs_at_the_forecast() -> None:
    forecast = forecast_at([RIVAL, ELSEWHERE], 0.1)
    found = bundle().process(fragments_and_rival(0.5), forecast)
    assert np.linalg.norm(found.xyz[0] - HIGH) < 0.02


def test_four_fragments_do_not_outvote_a_forecast_that_is_far_from_them() -> None:
    x, y, z = RIVAL + np.array(RIVAL) - HIGH
    forecast = forecast_at([(x, y, z), ELSEWHERE], 0.1)
    found = bundle().process(fragments_and_rival(0.5), forecast)
    assert np.linalg.norm(found.xyz[0] - RIVAL) < 0.02
