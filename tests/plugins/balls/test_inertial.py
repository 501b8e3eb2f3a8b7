"""`balls.inertial`: what is learnt from the motion, and what the readings are good for."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from tests.plugins.balls.inertial_paths import (
    RATE,
    ROOM,
    SENSOR,
    Errors,
    Motion,
    Run,
    filter_of,
    position,
    readings,
    tracked,
)

from followspot import Array, Context, Room, Sensor, at
from followspot.inertial import Inertial
from followspot.message_checks.sealing import seal
from followspot.messages import identical
from followspot.tracking import LOST, PREDICTED, TRACKED
from followspot_balls.inertial.stage import InertialFilter
from followspot_balls.kalman import Kalman

REAL = Errors(gyroscope_bias=(0.006, -0.004, 0.008), accelerometer_bias=(0.05, -0.03, 0.04), delay=0.003)
SEEDS = [1, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in (2, 3))]
ARM = (0.012, -0.02, 0.015)


@lru_cache
def hidden_run(seed: int) -> tuple[InertialFilter, Run]:
    """A target that rests for 1 s, and is hidden from 5.0 to 6.0 s."""
    stage = filter_of()
    motion = Motion(seed, arm=ARM)
    return stage, tracked(stage, motion, 6.5, errors=REAL, seed=seed, hidden=lambda t: 5.0 < t < 6.0)


@pytest.mark.parametrize("seed", SEEDS)
def test_heading_lever_arm_and_delay_are_learnt_from_motion_alone(seed: int) -> None:
    stage, run = hidden_run(seed)
    resting, moved = run.time < 1.0, (run.time > 4.0) & (run.time < 5.0)
    assert np.isnan(run.turn_error[resting]).all()
    stated = np.degrees([t.orientation_sigma[0] for t in run.tracks])[moved]
    assert stated.max() < 1.0
    assert (run.turn_error[moved] < 3.0 * stated).all()
    assert run.error[moved].max() < 0.006
    nav = stage.navigators["imu"].frame_states[-1].nav
    assert nav is not None
    assert np.abs(nav.lever_arm - np.array(ARM)).max() < 0.004
    assert abs(nav.delay - REAL.delay) < 0.001
    sigma = np.degrees(run.tracks[-1].orientation_sigma[0])
    assert 0.05 < sigma < 1.0


@pytest.mark.parametrize("seed", SEEDS)
def test_gap_of_a_second_is_bridged_with_an_honest_sigma(seed: int) -> None:
    _, run = hidden_run(seed)
    gap = (run.time > 5.0) & (run.time < 6.0)
    shown = [t for t, hidden in zip(run.tracks, gap, strict=True) if hidden]
    assert all(t.state.tolist() == [PREDICTED] for t in shown)
    assert run.error[gap].max() < 0.06
    assert run.turn_error[gap].max() < 1.0
    sigma = np.array([t.sigma[0] for t in shown])
    offset = np.array([t.xyz[0] for t in shown]) - run.truth[gap]
    assert (np.abs(offset) < 3.5 * sigma).all()
    assert sigma[0].max() < 0.005
    assert 0.01 < sigma[-1].max() < 0.1
    assert run.tracks[-1].state.tolist() == [TRACKED]


def test_late_readings_are_used_as_if_they_had_come_in_time() -> None:
    motion, late = Motion(4, arm=ARM), {"late": lambda t: 0.25 if 3.0 < t < 3.5 else 0.0}
    timely = tracked(filter_of(), motion, 4.3, errors=REAL)
    delayed = tracked(filter_of(), motion, 4.3, errors=REAL, **late)
    after, waiting = timely.time > 3.76, (timely.time > 3.1) & (timely.time < 3.2)
    assert (
        timely.tracks[int(waiting.argmax())].xyz.tobytes()
        != delayed.tracks[int(waiting.argmax())].xyz.tobytes()
    )
    assert after.any()
    for one, other, compared in zip(timely.tracks, delayed.tracks, after, strict=True):
        if compared:
            assert one.xyz.tobytes() == other.xyz.tobytes()
            assert one.quaternion.tobytes() == other.quaternion.tobytes()


def test_readings_that_are_too_late_are_left_out_and_told() -> None:
    told: list[str] = []
    stage = InertialFilter(Context(name="track", room=ROOM, warn=told.append), history=0.2)
    stage.setup()
    run = tracked(stage, Motion(1), 4.0, late=lambda t: 0.5 if 2.5 < t < 2.7 else 0.0)
    assert len(told) == 1
    assert "imu" in told[0]
    assert "history" in told[0]
    assert np.nanmax(run.error[run.time > 1.0]) < 0.05


@pytest.mark.parametrize(
    ("delay", "late", "missing"),
    [(0.0, 0.0, False), (-100.0, 0.0, True), (0.0, 1000.0, True)],
    ids=["in time", "of another clock", "stopped after a second"],
)
def test_a_sensor_without_readings_of_the_present_is_told_once(
    delay: float, late: float, missing: bool
) -> None:
    told: list[str] = []
    stage = InertialFilter(Context(name="track", room=ROOM, warn=told.append))
    stage.setup()
    tracked(stage, Motion(1), 4.6, errors=Errors(delay=delay), late=lambda t: late if t > 1 else 0.0)
    assert len([text for text in told if "readings of imu are missing for 3 s" in text]) == missing


@pytest.mark.parametrize(("delay", "believed"), [(0.05, True), (0.2, False), (-0.2, False)])
def test_sensor_that_the_positions_contradict_again_and_again_is_told_and_not_believed(
    delay: float, believed: bool
) -> None:
    told: list[str] = []
    stage = InertialFilter(Context(name="track", room=ROOM, warn=told.append))
    stage.setup()
    run = tracked(stage, Motion(1), 6.5, errors=Errors(delay=delay), hidden=lambda t: 5.6 < t < 6.4)
    hidden = (run.time > 5.7) & (run.time < 6.4)
    assert np.isfinite(run.error[hidden]).all() == believed
    assert np.isnan(run.error[hidden]).all() != believed
    assert np.nanmax(run.error) < 0.1
    assert len(told) == (not believed)
    assert believed or "readings of imu contradict the positions" in told[0]


def test_sensor_is_believed_again_when_the_positions_agree() -> None:
    stage = filter_of()
    jumps = (3.0, 3.4, 3.8)
    tracked(
        stage, Motion(1), 4.2, moved=lambda t: np.array([0.3 * sum(t > jump for jump in jumps), 0.0, 0.0])
    )
    (navigator,) = stage.navigators.values()
    assert len(navigator.contradictions) == 3
    last = navigator.contradictions[-1]
    assert navigator.contradicted(last)
    assert not navigator.contradicted(navigator.contradictions[0] + 10_000_000_000)
    other = filter_of()
    other.restore(stage.state())
    assert other.navigators["imu"].contradictions == navigator.contradictions


def test_readings_that_never_come_cost_no_more_than_they_must() -> None:
    run = tracked(filter_of(), Motion(2, arm=ARM), 6.0, errors=REAL, lost=lambda t: 3.5 < t < 3.7)
    assert run.error.max() < 0.08
    assert run.turn_error[run.time > 5.5].max() < 1.5


@pytest.mark.parametrize("moving", [True, False])
def test_a_sensor_that_is_stuck_in_motion_is_told_and_not_believed(moving: bool) -> None:
    told: list[str] = []
    stage = InertialFilter(Context(name="track", room=ROOM, warn=told.append))
    stage.setup()
    begin = 3.5 if moving else 0.3

    def stuck(t: Array) -> Array:
        return np.where((begin <= t) & (t < begin + 0.6), begin, t)

    run = tracked(stage, Motion(1, arm=ARM), 6.0, errors=REAL, hidden=lambda t: 3.9 < t < 4.0, read_at=stuck)
    assert len(told) == moving
    assert all("readings of imu do not change although it moves" in text for text in told)
    assert np.nanmax(run.error[run.time > 0.5]) < 0.2


def test_readings_that_come_too_slowly_or_are_no_numbers_are_told() -> None:
    told: list[str] = []
    stage = InertialFilter(Context(name="track", room=ROOM, warn=told.append))
    stage.setup()
    run = tracked(stage, Motion(1), 3.0, lost=lambda t: round(t * RATE) % 14 > 1)
    assert np.isnan(run.turn_error).all()
    (slow,) = told
    assert "come more than 0.05 s apart" in slow
    (first,) = readings(Motion(1), 2 / RATE)
    broken = Inertial("imu", first.time, first.turn_rate * np.nan, first.specific_force, first.field)
    for t in (3.0, 3.1):
        stage.process(position(None, t), (seal(at(round(t * 1e9), broken)),))
    assert len(told) == 2
    assert "no numbers or beyond what sensors can read" in told[1]


def test_a_clock_that_drifts_is_followed() -> None:
    stage = filter_of()
    motion = Motion(1, arm=ARM)
    run = tracked(stage, motion, 15.0, errors=Errors(drift=2e-3), hidden=lambda t: t > 5 and t % 3 > 2.5)
    later = run.time > 5.0
    assert run.error[later].max() < 0.08
    assert run.turn_error[later].max() < 6.0
    nav = stage.navigators["imu"].frame_states[-1].nav
    assert nav is not None
    assert abs(nav.delay - 0.03) < 0.01


def test_false_positions_are_rejected_until_they_persist() -> None:
    motion, aside = Motion(3), np.array([0.3, 0.0, 0.0])
    stage = filter_of()
    moved = tracked(stage, motion, 5.0, moved=lambda t: aside if 3.5 < t < 3.54 or t > 4.0 else 0.0 * aside)
    briefly, at_last = (moved.time > 3.4) & (moved.time < 4.0), moved.time > 4.3
    assert moved.error[briefly].max() < 0.02
    away = np.array([t.xyz[0] for t in moved.tracks]) - moved.truth
    assert np.linalg.norm(away[at_last] - aside, axis=1).max() < 0.03
    assert moved.turn_error[moved.time > 4.5].max() < 3.0


def test_target_without_a_sensor_is_filtered_as_by_kalman() -> None:
    motion = Motion(5)
    stage, plain = filter_of(), Kalman(Context(name="track", room=ROOM))
    plain.setup()
    for t in np.arange(0.0, 2.0, 1 / 60):
        seen = position(None if 1.0 < t < 1.1 else motion.xyz(np.array([t]))[0], float(t))
        one, other = stage.process(seen), plain.process(seen)
        for name in ("target", "state", "xyz", "velocity", "sigma"):
            assert getattr(one.tracks, name).tobytes() == getattr(other.tracks, name).tobytes()
        assert identical(one.forecast, other.forecast)
        assert np.isnan(one.tracks.quaternion).all()


def test_replacement_carries_on_bit_for_bit_in_a_gap() -> None:
    def replaced(n: int, stage: InertialFilter) -> InertialFilter:
        if n in (30, 150, 240):
            other = filter_of()
            other.restore(stage.state())
            return other
        return stage

    def hidden(t: float) -> bool:
        return 3.9 < t < 4.3

    motion = Motion(6, arm=ARM)
    alone = tracked(
        filter_of(), motion, 4.5, errors=REAL, hidden=hidden, late=lambda t: 0.03 * (t % 0.1 < 0.05)
    )
    swapped = tracked(
        filter_of(),
        motion,
        4.5,
        errors=REAL,
        hidden=hidden,
        late=lambda t: 0.03 * (t % 0.1 < 0.05),
        before=replaced,
    )
    assert all(identical(a, b) for a, b in zip(alone.tracks, swapped.tracks, strict=True))


def test_filters_take_the_state_of_each_other() -> None:
    motion = Motion(7)
    stage, plain = filter_of(), Kalman(Context(name="track", room=ROOM))
    plain.setup()
    for t in np.arange(0.0, 1.0, 1 / 60):
        plain.process(position(motion.xyz(np.array([t]))[0], float(t)))
    stage.restore(plain.state())
    seen = position(motion.xyz(np.array([1.0]))[0], 1.0)
    assert stage.process(seen).tracks.xyz.tobytes() == plain.process(seen).tracks.xyz.tobytes()
    plain.restore(stage.state())


def test_room_without_a_mounted_sensor_is_told() -> None:
    def told(*sensors: Sensor) -> list[str]:
        room = Room(targets=ROOM.targets, sensors={sensor.name: sensor for sensor in sensors})
        return [mistake.text for mistake in InertialFilter.check_room(InertialFilter.Params(), room, ())]

    assert told(SENSOR) == []
    assert told(Sensor("loose", "imu")) == ["no sensor of the room is mounted on a target"]
    assert told(SENSOR, Sensor("other", "imu", mount=SENSOR.mount)) == []


def test_vague_hidden_target_is_sought_everywhere_in_every_second_frame() -> None:
    stage, motion = filter_of(maximum_predicted_sigma=1.0), Motion(1)
    tracked(stage, motion, 4.0)
    states = []
    for n in range(400):
        outputs = stage.process(position(None, 4.0 + n / 60))
        states.append(int(outputs.forecast.state[0]))
        if outputs.forecast.state[0] == LOST:
            assert not outputs.forecast.xyz.any()
        if not len(outputs.tracks.target):
            break
    assert len(states) < 100
    assert {LOST, PREDICTED} <= set(states)


def test_forecast_of_a_hidden_target_is_one_frame_ahead() -> None:
    stage, motion = filter_of(), Motion(1)
    tracked(stage, motion, 4.0, hidden=lambda t: t > 3.8)
    outputs = stage.process(position(None, 4.0 - 0.1 + 1 / 60))
    assert 0.01 < outputs.forecast.period < 0.04
    assert stage.time == round((3.9 + 1 / 60) * 1e9)
