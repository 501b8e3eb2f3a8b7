"""A ball that one view alone shows: its sigmas are true, and it falls silent before it is wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.balls.scene import RADIUS, blobs_of, make_room, positions_at

from followspot.context import Context
from followspot.messages import Array, Header, stamped
from followspot.tracking import Forecast
from followspot_balls.bridge import Bridge
from followspot_balls.filtering.motion import Motion, initiated, slowed
from followspot_balls.kalman import Kalman

ROOM = make_room()
CAMERA = "cam1"
SEEN = 30
"""Frames in which the ball is measured, before the others lose it."""
SPOT = np.array([0.3, -0.2, RADIUS])


def reported(path: Array, fps: float = 60.0) -> tuple[Array, Array]:
    """Errors and sigmas, (F, 3) m each, in the frames with one view in which the ball is reported.

    path: (N, 3) m. Positions are 3 mm off, blobs 0.3 px.
    """
    rng, track = np.random.default_rng(0), Kalman(Context(room=ROOM))
    bridge = Bridge(Context(room=ROOM), colorless_time=0.0)  # however long no colour camera shows the ball
    bridge.setup()
    track.setup()
    forecast: Forecast | None = None
    errors, sigmas = [], []
    for frame, place in enumerate(path):
        x, y, z = place + rng.normal(size=3) * 0.003
        known = positions_at({0: (x, y, z)} if frame < SEEN else {}, frame / fps, sigma=0.003)
        blob = blobs_of(ROOM.cameras[CAMERA], [tuple(place)], [[True, True]])
        blob = replace(blob, xy=blob.xy + rng.normal(size=(1, 2)) * 0.3)
        header = Header(CAMERA, frame, known.header.time)
        found = bridge.process(known, (stamped(blob, header),), forecast)
        outputs = track.process(stamped(found, known.header))
        forecast = outputs.forecast
        if frame >= SEEN and len(outputs.tracks.target):
            errors.append(outputs.tracks.xyz[0] - place)
            sigmas.append(outputs.tracks.sigma[0])
    return np.array(errors), np.array(sigmas)


def moved(start: Array, velocity: Array, begin: float, fps: float = 60.0) -> Array:
    """A path of 60 frames: at rest until `begin` (s); 0.4 s later the velocity (m/s) is full."""
    time = np.maximum(np.arange(60) / fps - begin, 0.0)
    ramp = 0.4
    way = np.where(time < ramp, time**2 / (2 * ramp), time - ramp / 2)
    return np.asarray(start + way[:, None] * velocity)


@pytest.mark.parametrize("speed", [1.2, 3.0])
def test_a_ball_that_was_picked_up_is_not_taken_for_one_on_the_floor(speed: float) -> None:
    errors, sigmas = reported(moved(SPOT, np.array([0.0, 0.0, speed]), begin=0.35))
    assert len(errors) >= 10
    assert (np.abs(errors) < 3 * sigmas).all()


@pytest.mark.parametrize("speed", [1.0, 3.0])
def test_a_ball_that_moves_along_the_ray_falls_silent_before_it_is_elsewhere(speed: float) -> None:
    start = np.array([0.2, 0.2, 1.0])
    along = ROOM.cameras[CAMERA].center - start
    errors, sigmas = reported(moved(start, speed * along / np.linalg.norm(along), begin=0.0))
    assert len(errors) >= 3
    assert (np.abs(errors) < 3 * sigmas).all()
    assert np.linalg.norm(errors, axis=1).max() < 0.15


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_a_ball_on_the_floor_is_reported_as_long_as_a_target_may_be_missed(speed: float) -> None:
    errors, sigmas = reported(moved(SPOT, np.array([0.0, speed, 0.0]), begin=-1.0))
    assert len(errors) == Kalman.Params().maximum_missed_frames
    assert np.linalg.norm(errors, axis=1).max() < 0.03
    assert sigmas.max() < 0.03


@pytest.mark.parametrize("fps", [20.0, 30.0, 60.0])
@pytest.mark.parametrize("way", [(0.1, -0.1, 1.0), (0.4, 0.4, 0.8), (0.0, 0.0, 0.4)])
def test_a_ball_that_is_picked_up_while_one_view_shows_it_falls_silent(
    way: tuple[float, float, float], fps: float
) -> None:
    raised = np.clip((np.arange(60) - SEEN) / fps / 0.6, 0.0, 1.0)
    errors, _ = reported(SPOT + (raised * raised * (3 - 2 * raised))[:, None] * way, fps)
    assert len(errors) < 0.3 * fps
    assert np.linalg.norm(errors, axis=1).max() < 0.2  # 0.7 to 1.2 if it still seems to roll


@pytest.mark.parametrize("fps", [20.0, 30.0, 60.0])
def test_a_ball_that_slows_as_it_rolls_is_reported_on(fps: float) -> None:
    time = np.arange(60) / fps
    way = np.outer(2.0 * (1 - np.exp(-time / 2.0)), [0.7, -0.7, 0.0])  # 1 m/s, and 0.5 m/s^2 less
    errors, _ = reported(SPOT + way - way[SEEN], fps)
    assert len(errors) >= 24
    assert np.linalg.norm(errors, axis=1).max() < 0.05


@pytest.mark.parametrize("fps", [30.0, 60.0])
@pytest.mark.parametrize("lain", [2, 4, 6, 8])
def test_a_ball_that_has_just_fallen_on_the_floor_is_reported_on(lain: int, fps: float) -> None:
    before = np.maximum(SEEN - lain - np.arange(60), 0) / fps  # until it lies, s
    errors, _ = reported(SPOT + np.outer(2.0 * before, [0.0, 0.0, 1.0]), fps)
    assert len(errors) >= 24


def test_one_view_goes_on_after_a_hot_swap_as_before() -> None:
    stage, other = (Bridge(Context(room=ROOM)) for _ in range(2))
    for bridge in (stage, other):
        bridge.setup()
    stage.steady = stage.steady.updated(np.ones((2, 3)), np.ones(2, bool), 0.1)
    other.restore(stage.state())
    assert {name: values.tolist() for name, values in other.state().items()} == {
        name: values.tolist() for name, values in stage.state().items()
    }


def test_what_the_velocity_loses_its_covariance_gains() -> None:
    motion = initiated(Motion.zero(2), np.array([0, 1]), np.zeros((2, 3)), np.tile(np.eye(3), (2, 1, 1)), 0.5)
    motion.state[:, 3:] = [[2.0, -1.0, 0.5], [1.0, 1.0, 1.0]]
    slow = slowed(slowed(motion, np.array([0]), 0.8), np.array([0]), 0.5)
    assert slow.velocity[0] == pytest.approx(0.4 * motion.velocity[0])
    before, after = (m.covariance[0, 3:, 3:] + np.outer(m.velocity[0], m.velocity[0]) for m in (motion, slow))
    assert after == pytest.approx(before)
    assert np.array_equal(slow.state[1], motion.state[1])
    assert np.array_equal(slow.covariance[1], motion.covariance[1])
