"""Targets of a Kalman filter that are measured at rest, or are not, frame by frame."""

from __future__ import annotations

from tests.plugins.balls.scene import make_room, positions_at

from followspot.context import Context
from followspot_balls.kalman import Kalman
from followspot_target_filter.stage import Outputs

FPS = 30
HERE, THERE = (0.0, 0.0, 1.0), (2.0, 0.0, 1.0)


def kalman(**params: object) -> Kalman:
    stage = Kalman(Context(room=make_room()), **params)
    stage.setup()
    return stage


def watch(
    stage: Kalman,
    frames: int,
    first: int = 0,
    seen: bool = True,
    place: tuple[float, float, float] = HERE,
    **how: object,
) -> list[Outputs]:
    """Run frames in which target 0 is measured at rest, or is not."""
    places = {0: place} if seen else {}
    return [
        stage.process(positions_at(places, (first + i) / FPS, **how))  # type: ignore[arg-type]
        for i in range(frames)
    ]
