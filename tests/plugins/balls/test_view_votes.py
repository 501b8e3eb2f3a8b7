"""Where fusions begin: where all views make the ball likeliest, though each shows a fragment of it."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.balls.scene import forecast_at, unweighed
from tests.plugins.balls.seen_points import CENTERS, HIGH, ROOM, bundle, candidates, undistorted, whole

from followspot.context import Context
from followspot.messages import Array
from followspot.tracking import Candidates, Forecast
from followspot_balls.bundle_fusion import Bundle
from followspot_balls.mean_shift import MeanShift

Fusion = type[MeanShift] | type[Bundle]
FUSIONS = pytest.mark.parametrize("fusion", [MeanShift, Bundle])
RIVAL = (0.1, 0.1, 1.5)
"""A place 30 cm from the ball."""
ELSEWHERE = (1.5, 1.5, 1.0)
OFF = np.array([[0.8, 0.6], [-0.6, 0.8], [0.8, -0.6], [-0.8, -0.6]])
"""Errors of the centres of fragments, px: each is one pixel off."""


def ready(fusion: Fusion) -> MeanShift | Bundle:
    stage = fusion(Context(room=ROOM))
    stage.setup()
    return stage


def fragments_and_rival(share: float, fragments: int = 4, depths: tuple[float, ...] = (0.0,)) -> Candidates:
    """A fifth of a ball in some views, and this share of something in two of them that agree exactly.

    depths: m, at which the second of them shows it along the ray of the first.
    """
    ball, rival = np.array(HIGH), np.array(RIVAL)
    xy: list[Array] = list((undistorted(ball) + OFF)[:, None])
    area: list[Array] = list((0.2 * whole(ball))[:, None])
    xy[fragments:] = [np.zeros((0, 2))] * (4 - fragments)
    area[fragments:] = [np.zeros(0)] * (4 - fragments)
    ray = (rival - CENTERS[0]) / np.linalg.norm(rival - CENTERS[0])
    for view, places in enumerate(([rival], [rival + depth * ray for depth in depths])):
        xy[view] = np.vstack([xy[view], *(undistorted(place)[view] for place in places)])
        area[view] = np.append(area[view], [share * whole(rival)[view]] * len(places))
    return candidates(xy, area, [[[True, False]] * len(points) for points in xy])


def beyond_ball(distance: float) -> Forecast:
    """A forecast that is off the ball by this, m, towards the rival and behind it."""
    ball, rival = np.array(HIGH), np.array(RIVAL)
    x, y, z = ball + distance * (rival - ball) / np.linalg.norm(rival - ball)
    return forecast_at([(x, y, z), ELSEWHERE], 0.05)


def test_four_fragments_outvote_two_larger_blobs_elsewhere() -> None:
    found = unweighed(bundle()).process(fragments_and_rival(0.5), None)
    assert np.linalg.norm(found.xyz[0] - HIGH) < 0.02
    assert found.support[0] == 6


def test_whole_balls_outvote_as_many_fragments() -> None:
    found = unweighed(bundle()).process(fragments_and_rival(1.0, fragments=2), None)
    assert np.linalg.norm(found.xyz[0] - RIVAL) < 0.01


@FUSIONS
def test_four_fragments_outvote_two_larger_blobs_nearer_to_the_forecast(fusion: Fusion) -> None:
    found = ready(fusion).process(fragments_and_rival(0.5), beyond_ball(0.2))
    assert np.linalg.norm(found.xyz[0] - HIGH) < 0.03


@FUSIONS
def test_several_pairs_of_two_views_do_not_outvote_four_views(fusion: Fusion) -> None:
    every = fragments_and_rival(0.5, depths=tuple(np.linspace(-0.02, 0.02, 9)))
    of_rival = every.blob > 0
    pairs = every.where(of_rival[:, 0] == of_rival[:, 1])
    assert pairs.targets[:, 0].sum() == 6 + 9
    found = ready(fusion).process(pairs, beyond_ball(0.2))
    assert np.linalg.norm(found.xyz[0] - HIGH) < 0.03


@FUSIONS
def test_four_fragments_do_not_outvote_a_forecast_that_is_far_from_them(fusion: Fusion) -> None:
    found = ready(fusion).process(fragments_and_rival(0.5), beyond_ball(0.5))
    assert np.linalg.norm(found.xyz[0] - RIVAL) < 0.03
