"""Positions without numbers, of a fusion that divided by zero: no measurement, and the user is told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.plugins.balls.scene import make_room, positions_at
from tests.plugins.balls.watched import FPS, HERE

from followspot.context import Context
from followspot.tracking import MISSING, TRACKED
from followspot_balls.kalman import Kalman


@pytest.mark.parametrize("coordinate", [math.nan, math.inf, -math.inf])
def test_a_position_that_is_no_number_is_no_measurement(coordinate: float) -> None:
    told: list[str] = []
    stage = Kalman(Context(name="track", room=make_room(), warn=told.append))
    stage.setup()
    for frame in range(10):
        stage.process(positions_at({0: HERE}, frame / FPS))
    outputs = stage.process(positions_at({0: (coordinate, 0.0, 1.0), 1: HERE}, 10 / FPS))
    assert outputs.forecast.state[0] == MISSING
    assert np.isfinite(outputs.tracks.xyz).all()
    outputs = stage.process(positions_at({0: HERE}, 11 / FPS))
    assert outputs.forecast.state[0] == TRACKED
    assert outputs.tracks.xyz[0] == pytest.approx(HERE, abs=0.01)
    stage.close()
    assert "left out 1 positions with NaN or infinite coordinates" in told[0]


def test_positions_that_are_numbers_are_no_reason_to_warn() -> None:
    told: list[str] = []
    stage = Kalman(Context(name="track", room=make_room(), warn=told.append))
    stage.setup()
    stage.process(positions_at({0: HERE, 1: HERE}, 0.0))
    stage.close()
    assert "NaN" not in " ".join(told)
