"""`imu.orientation`: inclination from readings alone, by either method."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from followspot import Array, Context, Member, Room, Sensor, at
from followspot.errors import InputError
from followspot.inertial import Inertial, Orientation
from followspot.message_checks.sealing import seal
from followspot.messages import identical
from followspot.rotation import from_rotation_vector, inverse, multiply, rotation_vector, turned
from followspot_imu.attitude import Complementary
from followspot_imu.inclination_error import first_inclination
from followspot_imu.orientation import FindOrientation
from followspot_imu.reading_rate import usual_period
from followspot_imu.resampling import UNKNOWN, propagated_field

RATE = 100.0
METHODS = ["vqf", "complementary"]
S = 1_000_000_000


def quaternion(time: Array) -> Array:
    """A sensor that rests for 2 s, then swings about all axes."""
    s = np.maximum(time - 2.0, 0.0)[:, None]
    swing = np.array([0.8, 0.5, 0.3]) * np.sin(s * np.array([1.1, 1.7, 0.6]))
    return multiply(from_rotation_vector(swing), from_rotation_vector(np.array([0.4, -0.3, 0.9])))


def messages(seconds: float, bias: float = 0.0, count: int = 5, rate: float = RATE) -> list[Inertial]:
    time = np.arange(round(seconds * rate)) / rate
    q, before, after = (quaternion(time + shift) for shift in (0.0, -0.5 / rate, 0.5 / rate))
    turning = rotation_vector(multiply(inverse(before), after)) * rate + bias
    force = turned(inverse(q), np.array([0.0, 0.0, 9.81]))
    stamp = np.rint(time * 1e9).astype(np.int64)
    parts = [slice(i, i + count) for i in range(0, len(time), count)]
    return [
        seal(
            at(
                int(stamp[p][-1]),
                Inertial("imu0", stamp[p], turning[p], force[p], np.full_like(force[p], np.nan)),
            )
        )
        for p in parts
    ]


def cut(readings: Inertial, count: int) -> list[Inertial]:
    """The readings in messages of so many each."""
    numbers = np.arange(len(readings.time)) // count
    return [readings.where(numbers == number) for number in np.unique(numbers)]


def joined(one: Inertial, other: Inertial) -> Inertial:
    """The readings of both in one message."""
    names = ("time", "turn_rate", "specific_force", "field")
    both = {name: np.concatenate([getattr(one, name), getattr(other, name)]) for name in names}
    return replace(other, **both)


def stage(
    rate: float | None = RATE, warn: Callable[[str], None] = lambda text: None, **params: object
) -> FindOrientation:
    room = Room(sensors={"imu0": Sensor("imu0", "imu", rate=rate)})
    made = FindOrientation(Context(room=room, member=Member("sensors", "imu0"), warn=warn), **params)
    made.setup()
    return made


def inclinations(found: list[Orientation]) -> Array:
    """Angle between the true and the found direction upward at each reading, degrees."""
    up = np.array([0.0, 0.0, 1.0])
    angles = []
    for message in found:
        true = turned(inverse(quaternion(message.time / 1e9)), up)
        angles.append(np.arccos(np.clip((turned(inverse(message.quaternion), up) * true).sum(axis=1), -1, 1)))
    return np.degrees(np.concatenate(angles))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rate", [RATE, None])
def test_inclination_is_right_and_heading_steady(method: str, rate: float | None) -> None:
    made = stage(rate, method=method)
    found = [out for m in messages(12.0) if (out := made.process(m)) is not None]
    assert sum(len(m.time) for m in found) == 1200
    assert inclinations(found)[100:].max() < 1.0
    heading = [
        rotation_vector(multiply(m.quaternion, inverse(quaternion(m.time / 1e9))))[:, 2] for m in found
    ]
    drift = np.degrees(np.concatenate(heading)[200:])
    assert np.ptp(drift) < 1.0
    sigma = np.concatenate([m.inclination_sigma for m in found])
    assert sigma[0] > 0.1
    assert sigma[-1] < 0.03


def test_vqf_learns_the_bias_of_the_gyroscope() -> None:
    found = {}
    for method in METHODS:
        made = stage(method=method)
        found[method] = inclinations([m for r in messages(12.0, 0.01) if (m := made.process(r)) is not None])[
            600:
        ]
    assert found["vqf"].max() < 1.0
    assert found["complementary"].max() > 1.0


@pytest.mark.parametrize("method", METHODS)
def test_missing_readings_are_interpolated(method: str) -> None:
    made = stage(method=method)
    kept = [m for n, m in enumerate(messages(12.0)) if n % 7 != 3]
    assert inclinations([out for m in kept if (out := made.process(m)) is not None])[100:].max() < 2.0


def test_long_gap_begins_anew() -> None:
    made = stage()
    found = [
        m for r in messages(8.0) if not 4.0 < r.header.time / 1e9 < 6.0 and (m := made.process(r)) is not None
    ]
    sigma = np.concatenate([m.inclination_sigma for m in found])
    time = np.concatenate([m.time for m in found]) / 1e9
    assert sigma[time < 4.0][-1] < 0.1
    assert sigma[time > 6.0][0] > 0.15


def test_a_gap_within_a_message_begins_anew_behind_it() -> None:
    made = stage()
    (whole,) = messages(8.0, count=800)
    before, after = whole.where(whole.time < 4.03 * S), whole.where(whole.time > 6.0 * S)
    readings = [*cut(before, 5), joined(before.where(before.time >= 4.0 * S), after), *cut(after, 5)]
    found = [m for r in readings if (m := made.process(r)) is not None]
    late = [m for m in found if m.time[0] > 6.0 * S]
    assert late[0].inclination_sigma[0] > 0.15
    assert inclinations(late)[100:].max() < 2.0


@pytest.mark.parametrize(("every", "first"), [(1, 0), (4, 0), (4, 3), (40, 39)])
def test_a_magnetometer_that_reads_less_often_tells_the_heading(every: int, first: int) -> None:
    said: list[str] = []
    made = stage(warn=said.append, magnetometer=True)
    number, found = 0, []
    for message in messages(12.0):
        rows = number + np.arange(len(message.time))
        number += len(rows)
        field = turned(inverse(quaternion(message.time / S)), np.array([0.0, 20.0, -40.0]))
        read = (rows % every == first)[:, None]
        out = made.process(replace(message, field=np.where(read, field, np.nan)))
        found += [out] if out is not None else []
    error = [rotation_vector(multiply(m.quaternion, inverse(quaternion(m.time / S)))) for m in found]
    assert np.degrees(np.abs(np.concatenate(error)[100:])).max() < 1.5
    assert said == []


def test_a_sensor_without_a_magnetometer_is_told_and_has_its_own_heading() -> None:
    said: list[str] = []
    made = stage(warn=said.append, magnetometer=True)
    found = [m for r in messages(6.0) if (m := made.process(r)) is not None]
    assert inclinations(found)[100:].max() < 1.0
    assert said == ["the sensor has no magnetometer: the heading is arbitrary"]


@pytest.mark.parametrize("method", METHODS)
def test_replacement_carries_on_bit_for_bit(method: str) -> None:
    one, other = stage(method=method), stage(method=method)
    readings = messages(6.0)
    for m in readings[:70]:
        one.process(m)
    other.restore(one.state())
    for m in readings[70:]:
        a, b = one.process(m), other.process(m)
        assert a is not None
        assert b is not None
        assert identical(a, b)


def test_package_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "vqf", None)
    with pytest.raises(InputError, match="not installed") as raised:
        stage()
    assert "pip install 'followspot[imu]'" in str(raised.value)
    stage(method="complementary")


def test_repeated_and_unknown_readings_are_left_out() -> None:
    made = stage()
    first, second = messages(0.1)
    assert made.process(first) is not None
    assert made.process(first) is None
    broken = Inertial("imu0", second.time, second.turn_rate * np.nan, second.specific_force, second.field)
    assert made.process(seal(at(second.header.time, broken))) is None


def test_first_inclination_is_as_vague_as_the_speed_that_may_be_gained_meanwhile() -> None:
    age = np.array([0.01, 1.0, 3.0, 60.0])
    sigma = first_inclination(age, 3.0)
    assert sigma[0] == pytest.approx(1.0, abs=0.01)
    assert sigma[1:3] == pytest.approx(3.0 / (9.81 * age[1:3]) * np.exp(-age[1:3] / 6.0))
    assert sigma[3] < 1e-6


@pytest.mark.parametrize("burst", [1, 2, 5, 20, 40])
def test_period_of_readings_that_come_in_bursts_is_that_of_all(burst: int) -> None:
    number = np.arange(200)
    time = 10_000_000 * burst * (number // burst) + 1000 * (number % burst)
    assert usual_period(time) == pytest.approx(0.01, rel=0.25)


def test_period_is_that_of_readings_that_did_not_wait_nor_are_missing() -> None:
    time = 5_000_000 * np.arange(100)
    waited = np.concatenate([-40_000 + 1000 * np.arange(40), time])
    assert [usual_period(waited[: 40 + n]) for n in (0, 8, 60)] == [None, None, pytest.approx(0.005)]
    kept = np.random.default_rng(0).random(100) < 0.7
    assert usual_period(time[kept]) == pytest.approx(0.005)


def test_bursts_without_a_rate_are_not_filled_up_with_readings() -> None:
    made = stage(None, method="complementary")
    rows = []
    made.filter_of = lambda period: Counted(rows)  # type: ignore[method-assign]
    for n, m in enumerate(messages(4.0, count=5)):
        stamp = 50_000_000 * n + 1000 * np.arange(5)
        made.process(
            seal(at(int(stamp[-1]), Inertial("imu0", stamp, m.turn_rate, m.specific_force, m.field)))
        )
    assert 0 < sum(rows) < 1000


class Counted(Complementary):
    """A filter that counts the readings that it is given."""

    def __init__(self, rows: list[int]) -> None:
        super().__init__(0.01, 3.0)
        self.rows = rows

    def update(self, turn_rate: Array, specific_force: Array, field: Array | None) -> Array:
        self.rows.append(len(turn_rate))
        return super().update(turn_rate, specific_force, field)


@pytest.mark.parametrize(("said", "warned"), [(100.0, False), (110.0, False), (50.0, True), (400.0, True)])
def test_a_rate_that_is_not_that_of_the_readings_is_told_once(said: float, warned: bool) -> None:
    told: list[str] = []
    made = stage(said, told.append, method="complementary")
    for m in messages(3.0):
        made.process(m)
    assert len(told) == warned
    assert all(f"100 readings come a second where {said:g} are said" in text for text in told)


def test_a_sensor_that_is_stuck_in_motion_is_told_once_and_begins_anew() -> None:
    told: list[str] = []
    made = stage(warn=told.append, method="complementary")
    found, last = [], None
    for n, m in enumerate(messages(8.0)):
        last = m if n <= 80 else last  # 4.0 s
        if last is not None and 80 < n <= 110:
            values = (np.repeat(each[-1:], 5, axis=0) for each in (last.turn_rate, last.specific_force))
            m = seal(at(m.header.time, Inertial("imu0", m.time, *values, m.field)))
        if n == 95:
            other = stage(warn=told.append, method="complementary")
            other.restore(made.state())
            made = other
        found.append(made.process(m))
    assert len([text for text in told if "do not change although the sensor moves" in text]) == 2
    given = [n for n, m in enumerate(found) if m is not None]
    assert set(range(160)) - set(given) == set(range(82, 111))
    assert found[111] is not None
    assert found[111].inclination_sigma[0] > 0.2


def test_a_sensor_without_noise_may_repeat_its_reading_at_rest() -> None:
    told: list[str] = []
    made = stage(warn=told.append, method="complementary")
    assert all(made.process(m) is not None for m in messages(2.0))
    assert not told


@pytest.mark.parametrize("last", [UNKNOWN, np.array([20.0, -3.0, -40.0])])
def test_a_field_that_was_not_measured_is_the_one_before_rotated_back(last: Array) -> None:
    rng = np.random.default_rng(3)
    field, rotation = rng.normal(size=(20, 3)) * 40.0, rng.normal(size=(20, 3)) * 0.1
    measured = np.isin(np.arange(20), [4, 5, 13])
    field[~measured] = np.nan
    found = propagated_field(last, field, rotation)
    np.testing.assert_array_equal(found[measured], field[measured])
    before = np.concatenate([last[None], found])[:-1]
    expected = turned(inverse(from_rotation_vector(rotation)), before)
    np.testing.assert_array_equal(found[~measured], expected[~measured])
