"""The performance: what balls and people do, as a function of time alone."""

from __future__ import annotations

import numpy as np
import pytest

from followspot import StageParams
from followspot.context import Context
from followspot.tracking import Blobs
from followspot_sim.performance import Performance
from followspot_sim.rounds import ROUND
from followspot_sim.world import Setting, World

RADIUS = 0.0762


def world(seed: int, people: int, balls: int, hide: bool = True) -> World:
    return World(Setting(seed, 60.0, people, hide, -1, (RADIUS,) * balls, (0.0, 0.0, 1.0, 0.0)))


def paths(of: World, frames: int) -> np.ndarray:
    return np.array([of.balls(frame / 60.0) for frame in range(frames)])


@pytest.mark.parametrize(("seed", "people", "balls"), [(7, 2, 3), (12, 4, 6), (3, 0, 3), (5, 3, 4)])
def test_balls_move_without_jumps_at_less_than_five_metres_per_second(seed, people, balls):
    speed = np.linalg.norm(np.diff(paths(world(seed, people, balls), 900), axis=0), axis=2) * 60
    assert speed.max() < 5.0
    assert speed.max() > 0.5


@pytest.mark.parametrize(("seed", "people", "balls"), [(7, 2, 3), (12, 4, 6), (3, 0, 3)])
def test_balls_do_not_pass_through_each_other(seed, people, balls):
    path = paths(world(seed, people, balls), 900)
    i, j = np.triu_indices(balls, 1)
    assert np.linalg.norm(path[:, i] - path[:, j], axis=2).min() > 2 * RADIUS


def test_balls_stay_in_the_room_and_above_its_floor():
    path = paths(world(12, 4, 6), 1200)
    assert np.abs(path[..., :2]).max() < 2.3
    assert path[..., 2].min() > RADIUS - 1e-9
    assert path[..., 2].max() < 2.2


def test_a_moment_does_not_depend_on_what_was_asked_before():
    forward, backward = world(4, 2, 3), world(4, 2, 3)
    frames = (0, 250, 500, 750)
    late = {frame: backward.scene(frame) for frame in reversed(frames)}
    for frame in frames:
        early = forward.scene(frame)
        assert np.array_equal(early.balls, late[frame].balls)
        assert np.array_equal(early.limbs, late[frame].limbs)


def test_another_seed_is_another_performance():
    assert not np.allclose(world(1, 2, 3).balls(5.0), world(2, 2, 3).balls(5.0))


def test_a_demo_shows_every_act():
    of = world(7, 2, 3)
    of.scene(1199)
    moves = [move for act in of._rounds[1:8] for move in act.moves]
    acts = {(m.before.kind, m.after.kind, m.leave < m.arrive) for m in moves}
    assert {("hand", "floor", False), ("floor", "hand", False), ("floor", "floor", True)} <= acts
    assert {("hand", "hand", True), ("hand", "bag", False), ("bag", "hand", False)} <= acts


def test_a_thrown_ball_falls_as_heavy_things_do():
    of = world(7, 2, 3)
    of.scene(1199)
    number, ball, move = next(
        (n, b, m)
        for n, act in enumerate(of._rounds[1:])
        for b, m in enumerate(act.moves)
        if m.before.kind == "hand" and m.leave < m.arrive
    )
    begin, step = number * ROUND + move.leave + 0.05, 0.01
    path = np.array([of.balls(begin + k * step)[ball] for k in range(50)])
    acceleration = np.diff(path, n=2, axis=0) / step**2
    assert np.allclose(acceleration, [0, 0, -9.81], atol=1e-6)


def test_without_people_balls_roll_on_the_floor():
    path = paths(world(3, 0, 3), 600)
    assert np.allclose(path[..., 2], RADIUS)
    assert np.ptp(path[..., :2], axis=0).max() > 0.5


def test_nobody_hides_a_ball_where_that_is_switched_off():
    for seed in range(4):
        of = world(seed, 2, 3, hide=False)
        of.scene(1500)
        assert all(move.after.kind != "bag" for act in of._rounds for move in act.moves)


def test_a_ball_alone_is_far_from_where_it_was_a_frame_ago():
    alone = World(Setting(1, 60.0, 0, True, 1, (RADIUS,) * 3, (0.0, 0.0, 1.0, 0.0)))
    path = np.array([alone.scene(frame).balls for frame in range(20)])
    assert np.isnan(path[:, [0, 2]]).all()
    assert np.linalg.norm(np.diff(path[:, 1], axis=0), axis=1).min() > 0.5


class Paced(Performance):
    class Params(StageParams):
        frames: int = 3
        fps: float = 10.0
        realtime: bool = True


def test_frames_are_due_from_the_beginning_of_the_run_on():
    paced = Paced(Context(run_begun=lambda: 1_000))
    due = [paced.at(frame, Blobs.empty()).header.entered for frame in paced.frames()]
    assert due == [1_000, 100_001_000, 200_001_000]
