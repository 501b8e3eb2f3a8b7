"""`filters.kalman_filterpy` takes the place of `balls.kalman`; of the same model it is an oracle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from tests.plugins.balls.scene import make_room, positions_at

from followspot.context import Context
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, stamped
from followspot.testing import check_stage
from followspot.tracking import PREDICTED, TRACKED, Positions
from followspot_balls.kalman import Kalman
from followspot_target_filter.stage import Outputs, TargetFilter

pytest.importorskip("filterpy")
from followspot_filters.kalman_filterpy import KalmanFilterpy

MODELS = ("constant_velocity", "constant_acceleration", "imm")
ROOM = make_room(("red", "green", "another red"))


def made(kind: type[TargetFilter], **params: object) -> TargetFilter:
    stage = kind(Context(room=ROOM), **params)
    stage.setup()
    return stage


def measurements(seed: int, frames: int = 150, speed: float = 0.03) -> Iterator[Positions]:
    """Random walks with hits, sharp and vague covariances, gaps short and long, uneven intervals."""
    rng = np.random.default_rng(seed)
    time, place, velocity = 0.0, rng.normal(size=(3, 3)), np.zeros((3, 3))
    hidden = np.zeros(3, int)
    for frame in range(frames):
        time += rng.choice([1, 1, 1, 2, 5]) / 60
        velocity += rng.normal(size=(3, 3)) * speed / 10
        velocity[rng.random(3) < 0.02] = rng.normal(size=3) * speed
        place += velocity
        hidden = np.where((hidden == 0) & (rng.random(3) < 0.05), rng.choice([1, 3, 40], 3), hidden - 1)
        hidden = np.maximum(hidden, 0)
        seen = np.flatnonzero(hidden == 0)
        axes = np.linalg.qr(rng.normal(size=(len(seen), 3, 3)))[0]
        covariance = (axes * np.exp(rng.uniform(-13, -7, (len(seen), 1, 3)))) @ axes.swapaxes(1, 2)
        covariance[rng.random(len(seen)) < 0.2] = np.nan
        support = rng.choice([0, 1, 2, 6], len(seen), p=[0.1, 0.1, 0.1, 0.7]).astype(np.int32)
        message = Positions(
            target=seen.astype(np.int32),
            xyz=place[seen] + rng.normal(0, 0.005, (len(seen), 3)),
            covariance=covariance,
            support=support,
            confirmed=support > 0,
            evident=support > 1,
            iterations=np.ones(len(seen), np.int32),
            predicted=support == 0,
        )
        yield seal(stamped(message, Header("test", frame, round(time * 1e9))))


def numbers(outputs: Outputs) -> list[Array]:
    return [
        getattr(message, column.name)
        for message in (outputs.tracks, outputs.forecast)
        for column in message.columns
    ]


def alike(ours: Outputs, theirs: Outputs) -> None:
    for a, b in zip(numbers(ours), numbers(theirs), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("gate", [1e9, 3.0])
@pytest.mark.parametrize("fade_time", [0.1, 0.0])
@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.thorough) for n in (1, 2))])
def test_constant_velocity_is_that_of_balls_kalman_to_1e_9(seed: int, gate: float, fade_time: float) -> None:
    given = {"bounce_gate": gate, "fade_time": fade_time}
    ours, theirs = made(Kalman, **given), made(KalmanFilterpy, **given)
    states: set[int] = set()
    for positions in measurements(seed):
        one, other = ours.process(positions), theirs.process(positions)
        alike(one, other)
        states |= {*one.forecast.state.tolist()}
    assert states == {0, 1, 2, 3}  # lost, tracked, missing and predicted have all been compared


@pytest.mark.parametrize("model", MODELS)
def test_all_models_keep_the_same_life_cycle_at_rest(model: str) -> None:
    """The life cycle asks for support and time, and hardly for the motion of what rests."""
    ours, theirs = made(Kalman), made(KalmanFilterpy, model=model)
    for positions in measurements(5, speed=0.0):
        one, other = ours.process(positions), theirs.process(positions)
        assert one.tracks.target.tolist() == other.tracks.target.tolist()
        measured = one.tracks.state == TRACKED
        assert np.abs(one.tracks.xyz - other.tracks.xyz)[measured].max(initial=0) < 0.02


@pytest.mark.parametrize("model", MODELS)
def test_a_stage_carries_on_from_its_own_checkpoint_to_the_bit(model: str) -> None:
    old, new = (made(KalmanFilterpy, model=model) for _ in range(2))
    messages = list(measurements(1, frames=60))
    for positions in messages[:40]:
        old.process(positions)
    new.restore(old.state())
    for positions in messages[40:]:
        for a, b in zip(numbers(old.process(positions)), numbers(new.process(positions)), strict=True):
            assert a.tobytes() == b.tobytes()


def test_models_carry_on_from_each_other_in_a_run() -> None:
    """Each restores the one before; what is exchanged is position and velocity."""
    messages = list(measurements(2, frames=100, speed=0.01))
    stages = [made(Kalman), *(made(KalmanFilterpy, model=model) for model in MODELS), made(Kalman)]
    constant = made(Kalman)
    for number, positions in enumerate(messages):
        stage = stages[number // 20]
        if number % 20 == 0 and number:
            stage.restore(stages[number // 20 - 1].state())
        one, other = stage.process(positions), constant.process(positions)
        assert one.tracks.target.tolist() == other.tracks.target.tolist()
        tracked = one.tracks.state != PREDICTED
        assert np.abs(one.tracks.xyz - other.tracks.xyz)[tracked].max(initial=0) < 0.05


def errors(place: Array, period: float, **params: object) -> Array:
    """Distances, m, of the filter's positions and of its forecasts from a path, (2, N) from frame 10 on."""
    rng = np.random.default_rng(3)
    stage = made(KalmanFilterpy, **params)
    found = []
    for frame, xyz in enumerate(place[:-1]):
        noisy = tuple(xyz + rng.normal(0, 0.004, 3))
        outputs = stage.process(positions_at({0: noisy}, frame * period))  # type: ignore[dict-item]
        now = np.linalg.norm(outputs.tracks.xyz[0] - xyz)
        found.append((now, np.linalg.norm(outputs.forecast.xyz[0] - place[frame + 1])))
    return np.array(found).T[:, 10:]


def test_constant_acceleration_foretells_a_toss_and_imm_a_bounce() -> None:
    """A ball in free flight at 30 Hz, and one that changes its velocity by 6 m/s every half second."""
    period = 1 / 30
    time = np.arange(60) * period
    toss = np.column_stack([time, 0 * time, 9 * time - 4.905 * time**2])
    bounces = np.column_stack([time, 0 * time, np.abs((3 * time + 1.5) % 3 - 1.5)])
    quiet = {"acceleration_sigma": 3.0, "bounce_gate": 1e9, "measurement_sigma": 0.004}
    cv, ca, imm = (
        [errors(path, period, model=model, jerk_sigma=20.0, **quiet).mean(axis=1) for path in (toss, bounces)]
        for model in MODELS
    )
    assert ca[0][1] < 0.8 * cv[0][1]
    assert imm[0][1] < 0.8 * cv[0][1]
    assert imm[1][0] < 0.5 * cv[1][0]
    assert imm[1][0] < 0.5 * ca[1][0]


@pytest.mark.thorough
def test_interacting_models_keep_the_promises_of_a_stage() -> None:
    check_stage(KalmanFilterpy, room=ROOM, messages=100, model="imm")
