"""Two balls in a small room, and detectors of its cameras."""

from __future__ import annotations

import numpy as np
from tests.plugins.balls.scene import forecast_at
from tests.plugins.balls.two_balls import ROOM

from followspot.context import Context
from followspot.stage import Stage

HERE, THERE = (0.1, 0.0, 1.0), (-0.4, 0.3, 0.8)
BALLS = {"red": np.array(HERE), "green": np.array(THERE)}
FORECAST = forecast_at([HERE, THERE])


def detector(kind: type[Stage], camera: str, **params: float) -> Stage:
    stage = kind(Context.serving(ROOM.cameras[camera], ROOM), **params)
    stage.setup()
    return stage
