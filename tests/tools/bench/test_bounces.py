"""Real balls that bounce, seen by virtual cameras: the filter must not cost accuracy where they turn."""

from __future__ import annotations

import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from bench.balls import bounces

REAL = dataset("ball-trajectories-tt3d")
SETS = {"side+oblique+back", "side+oblique", "side+back", "oblique+back"}


@pytest.mark.thorough
@needs_data("ball-trajectories-tt3d")
def test_the_filter_is_never_worse_than_no_filter_at_bounces_whichever_views_there_are() -> None:
    result = bounces.measure(REAL)
    assert set(result) == SETS
    for figures in result.values():
        for rmse_mm in figures.values():
            assert rmse_mm["filter"] <= rmse_mm["no filter"]
            assert rmse_mm["filter, covariance"] <= rmse_mm["no filter"]


@needs_data("ball-trajectories-tt3d")
def test_every_trajectory_bounces_once() -> None:
    found = [int(flight.bounce.sum()) for flight in bounces.flights(REAL)]
    assert len(found) == 70
    assert set(found) <= {3, 4}  # 25 Hz, two frames before and after; one begins too late for that


def test_a_bounce_is_where_a_falling_ball_turns() -> None:
    time = np.arange(200) / 180
    height = np.abs(0.8 - 2.0 * time)  # on the table at 0.4 s
    assert bounces.bounces(np.column_stack([time + 12.0, height])) == pytest.approx([0.4], abs=1 / 180)
    assert len(bounces.bounces(np.column_stack([time, 2.0 * time]))) == 0
