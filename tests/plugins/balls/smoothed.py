"""Paths, their noisy positions and tracks, and what `balls.smooth` makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from tests.plugins.balls.scene import make_room

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, stamped
from followspot.tracking import TRACKED, Positions, Tracks
from followspot_balls.smooth.stage import Smooth

PERIOD = 33_333_333
"""ns."""
ROOM = make_room()


def smooth(context: Context = Context(room=ROOM), **params: Any) -> Smooth:
    stage = Smooth(context, **params)
    stage.setup()
    return stage


def positions(frame: float, places: dict[int, Sequence[float]], sigma: float = 0.01, **how: Any) -> Positions:
    count = len(places)
    message = Positions(
        target=np.array(list(places), np.int32),
        xyz=np.array(list(places.values()), float).reshape(-1, 3),
        covariance=np.tile(np.eye(3) * sigma**2, (count, 1, 1)),
        support=np.full(count, how.get("support", 6), np.int32),
        confirmed=np.ones(count, bool),
        evident=np.ones(count, bool),
        iterations=np.ones(count, np.int32),
        predicted=np.zeros(count, bool),
    )
    return seal(stamped(message, Header("cam0", int(frame), round(frame * PERIOD))))


def tracks(
    frame: int, places: dict[int, Sequence[float]], state: int = TRACKED, sigma: float = 1e-3
) -> Tracks:
    count = len(places)
    message = Tracks(
        target=np.array(list(places), np.int32),
        state=np.full(count, state, np.uint8),
        xyz=np.array(list(places.values()), float).reshape(-1, 3),
        velocity=np.full((count, 3), 7.0),
        sigma=np.full((count, 3), sigma),
    )
    return seal(stamped(message, Header("cam0", frame, frame * PERIOD)))


def path(frames: int, seed: int = 1) -> Array:
    """A ball that accelerates at random, (frames, 3) m."""
    rng = np.random.default_rng(seed)
    return np.cumsum(np.cumsum(rng.normal(0, 6 / 30**2, (frames, 3)), axis=0), axis=0)


def noisy(places: Array, sigma: float = 0.01, seed: int = 2) -> Array:
    return places + np.random.default_rng(seed).normal(0, sigma, places.shape)
