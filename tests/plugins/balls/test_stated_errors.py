"""The errors that tracks state: that of their filter, and that they may have left their targets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import make_room, positions_at
from tests.plugins.balls.watched import FPS, HERE, kalman, watch

from followspot.context import Context
from followspot_balls.kalman import Kalman
from followspot_target_filter.departure import DEPARTURE_RATE, DEPARTURE_SIGMA


def stated(stage: Kalman, frames: int, first: int = 40, fps: int = FPS) -> list[float]:
    """The largest sigma of target 0, m, in frames in which one candidate shows it."""
    return [
        float(stage.process(positions_at({0: HERE}, i / fps, support=1)).tracks.sigma.max())
        for i in range(first, first + frames)
    ]


def test_a_track_that_few_candidates_show_states_that_it_may_have_left_its_target() -> None:
    """At a rate of departures, and no farther than tracks go astray; what three show at once is there."""
    stage = kalman()
    before = float(watch(stage, 40)[-1].tracks.sigma.max())
    sigma = stated(stage, 300)
    assert np.all(np.diff(sigma[1:]) > 0)
    left = 1 - np.exp(-DEPARTURE_RATE * np.array([10, 300]) / FPS)
    assert np.take(sigma, [9, 299]) == pytest.approx(
        np.hypot(before, DEPARTURE_SIGMA * np.sqrt(left)), rel=0.02
    )
    assert watch(stage, 1, first=340)[0].tracks.sigma.max() == pytest.approx(before, rel=0.02)


def test_what_a_track_states_depends_on_the_time_and_not_on_the_number_of_frames() -> None:
    slow, fast = kalman(measurement_sigma=1e-4), kalman(measurement_sigma=1e-4)
    for stage, fps in ((slow, 30), (fast, 120)):
        for i in range(fps):
            stage.process(positions_at({0: HERE}, i / fps))
    assert stated(slow, 30, first=30)[-1] == pytest.approx(
        stated(fast, 120, first=120, fps=120)[-1], rel=0.01
    )


def test_a_track_that_nothing_speaks_against_states_what_its_filter_does() -> None:
    """As where a target is never doubted: two cameras are all there are, no colours, a mark, or no doubt."""
    room = make_room()
    two = replace(room, cameras={name: room.cameras[name] for name in ("cam0", "cam1")})
    gray = replace(room, cameras={n: replace(c, kind="infrared") for n, c in room.cameras.items()})
    others = kalman(doubt_frames=0), kalman(marks={"red": HERE})
    for stage in (Kalman(Context(room=two)), Kalman(Context(room=gray)), *others):
        stage.setup()
        watch(stage, 40)
        for frame in range(40, 70):
            assert stated(stage, 1, first=frame) == [stage.motion.estimate.sigma[0].max()]
