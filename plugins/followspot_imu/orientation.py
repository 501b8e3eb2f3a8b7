"""The orientation of an inertial sensor from its readings alone."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from followspot import Array, Field, Stage, StageParams
from followspot.frame_times import NANOSECOND
from followspot.inertial import Inertial, Orientation
from followspot.messages import MAX_TIME
from followspot.rotation import canonical
from followspot.sensors.stuck_readings import REMEDY, runs, stuck
from followspot_imu.attitude import AttitudeFilter, Complementary
from followspot_imu.inclination_error import first_inclination
from followspot_imu.reading_rate import MINIMUM_READINGS, RateCheck, usual_period
from followspot_imu.resampling import UNKNOWN, at_even_times, propagated_field
from followspot_imu.versatile import Versatile

FIELD_TIME = 1.0
"""Longest time, s, to wait for the first reading of the magnetometer."""
MAXIMUM_TURN_RATE, MAXIMUM_FORCE = 100.0, 4000.0
"""Largest plausible turn rate, rad/s, and specific force, m/s^2, of a sensor."""


class FindOrientation(Stage):
    """Find the orientation of a sensor from its readings; z is upward, the heading is arbitrary.

    The rate of the readings is that of the sensor in the room; without it, it is measured from the first
    readings. The stage warns if readings come at another rate. Missing readings are interpolated; after a
    longer gap the filter begins anew.
    """

    class Params(StageParams):
        """The filter."""

        method: Literal["vqf", "complementary"] = Field(
            "vqf",
            description="vqf: accurate, learns the gyroscope's bias (pip install 'followspot[imu]'); "
            "complementary: simple, needs no package",
        )
        rate: float = Field(
            0.0, ge=0, le=1e5, unit="Hz", description="readings per second; 0: as the room says, or measured"
        )
        time_constant: float = Field(
            3.0,
            gt=0,
            unit="s",
            description="time over which the accelerometer corrects the inclination; raising it suits longer "
            "accelerations, lowering it larger biases",
        )
        magnetometer: bool = Field(
            False, description="use the magnetometer for the heading (vqf): only where no iron is near"
        )
        inclination_sigma: float = Field(
            0.02,
            gt=0,
            unit="rad",
            description="sigma of the inclination in motion, which the stage sends with each orientation; "
            "raising it lets receivers trust the inclination less",
        )
        maximum_gap: float = Field(
            0.5,
            gt=0,
            unit="s",
            description="gap in the readings after which the filter begins anew; raising it bridges longer "
            "gaps",
        )

    params: Params

    def setup(self) -> None:
        """Begin with an unknown orientation. Raises InputError if the method is not installed."""
        served = self.context.member
        sensor = self.room.sensors.get(served.name) if served and served.set == "sensors" else None
        self.rate = self.params.rate or ((sensor.rate or 0.0) if sensor else 0.0)
        self.filter_of(1 / MINIMUM_READINGS)
        self.rate_check = RateCheck(self.rate)
        self.latest = np.zeros(0, np.int64), np.zeros((0, 6))
        """The latest reading, (1, 6), and the time since when it has been the same, (1,) ns."""
        self.warned = False
        self.reset()

    def reset(self) -> None:
        """Forget the orientation."""
        self.filter: AttitudeFilter | None = None
        self.period, self.count, self.magnetic = 0.0, 0, False
        self.field = UNKNOWN
        """The field at the latest reading, (3,) uT."""
        self.time, self.values = np.zeros(0, np.int64), np.zeros((0, 9))

    def filter_of(self, period: float) -> AttitudeFilter:
        """A new filter for readings of a period, s."""
        kind = Versatile if self.params.method == "vqf" else Complementary
        return kind(period, self.params.time_constant)

    def process(self, readings: Inertial) -> Orientation | None:
        time, values = self.without_stuck(*plausible(readings))
        if len(self.time):
            new = time > self.time[-1]
            time, values = time[new], values[new]
        if not len(time):
            return None
        if warning := self.rate_check.warning(time):
            self.context.warn(warning)
        gaps = np.diff(np.concatenate([self.time[-1:], time])) * NANOSECOND > self.params.maximum_gap
        if gaps.any():
            behind = len(time) - len(gaps) + int(np.flatnonzero(gaps)[-1])
            time, values = time[behind:], values[behind:]
            self.reset()
        self.time, self.values = np.concatenate([self.time, time]), np.concatenate([self.values, values])
        first = len(self.time) - len(time)
        if self.filter is None:
            period = 1 / self.rate if self.rate else usual_period(self.time)
            if period is None or self.awaits_field():
                return None
            first = self.initialise(period)
        message = self.filtered(readings.sensor, first)
        self.time, self.values = self.time[-1:], self.values[-1:]
        return message

    def without_stuck(self, time: Array, values: Array) -> tuple[Array, Array]:
        """Readings, (N,) ns and (N, 9), without those of a sensor that is stuck; warns of these once."""
        since, latest = self.latest
        times, readings = np.concatenate([since, time]), np.concatenate([latest, values[:, :6]])
        repeated = stuck(times, readings)[len(since) :]
        self.latest = times[runs(readings)[-1:]], readings[-1:]
        if repeated.any() and not self.warned:
            self.warned = True
            self.context.warn(f"readings do not change although the sensor moves, and are left out: {REMEDY}")
        return time[~repeated], values[~repeated]

    def awaits_field(self) -> bool:
        """Whether a magnetometer that reads less often than the sensor may still give its first reading."""
        if not self.params.magnetometer or self.field_known().any():
            return False
        return bool((self.time[-1] - self.time[0]) * NANOSECOND < FIELD_TIME)

    def field_known(self) -> Array:
        """Whether the magnetometer gave the field with each reading, (N,)."""
        return np.asarray(np.isfinite(self.values[:, 6:]).all(axis=1))

    def initialise(self, period: float) -> int:
        """Make the filter for the readings so far, with a magnetometer for those from its first field on.

        Returns the number of the first reading, 0. period: s.
        """
        self.period = period
        self.filter = self.filter_of(self.period)
        known = self.field_known()
        self.magnetic = self.params.magnetometer and bool(known.any())
        if self.magnetic:
            start = int(known.argmax())
            self.time, self.values = self.time[start:], self.values[start:]
        elif self.params.magnetometer:
            self.context.warn("the sensor has no magnetometer: the heading is arbitrary")
        return 0

    def filtered(self, sensor: str, first: int) -> Orientation:
        """The orientations of the readings from one on, with the filter brought up to them."""
        assert self.filter is not None
        before = max(first - 1, 0)
        values, index = at_even_times(self.time[before:], self.values[before:, :6], self.period)
        field = np.full((len(values), 3), np.nan)
        field[index] = self.values[before:, 6:]
        if first:
            values, field, index = values[1:], field[1:], index[1:] - 1
        if self.magnetic:
            field = propagated_field(self.field, field, values[:, :3] * self.period)
            self.field = field[-1]
        found = self.filter.update(values[:, :3], values[:, 3:6], field if self.magnetic else None)
        age = (self.count + index + 1) * self.period
        self.count += len(values)
        sigma = np.hypot(self.params.inclination_sigma, first_inclination(age, self.params.time_constant))
        return Orientation(sensor, self.time[first:], canonical(found[index]), sigma)

    def state(self) -> Any:
        return {
            "filter": self.filter.state() if self.filter else {},
            "period": self.period,
            "count": self.count,
            "magnetic": self.magnetic,
            "field": self.field,
            "time": self.time,
            "values": self.values,
            "since": self.latest[0],
            "latest": self.latest[1],
        }

    def restore(self, state: Any) -> None:
        self.period, self.count = float(state["period"]), int(state["count"])
        self.magnetic, self.field = bool(state["magnetic"]), np.array(state.get("field", UNKNOWN))
        self.time, self.values = np.array(state["time"]), np.array(state["values"])
        self.latest = np.array(state["since"]), np.array(state["latest"])
        if state["filter"]:
            self.filter = self.filter_of(self.period)
            self.filter.restore(state["filter"])


def plausible(readings: Inertial) -> tuple[Array, Array]:
    """Times (N,) ns, rising, and values (N, 9) of the plausible readings."""
    values = np.concatenate([readings.turn_rate, readings.specific_force, readings.field], axis=1)
    turn_rate, force = np.abs(values[:, :3]).max(axis=1), np.abs(values[:, 3:6]).max(axis=1)
    kept = (turn_rate <= MAXIMUM_TURN_RATE) & (force <= MAXIMUM_FORCE) & (np.abs(readings.time) <= MAX_TIME)
    time, first = np.unique(readings.time[kept], return_index=True)
    return time, values[kept][first]
