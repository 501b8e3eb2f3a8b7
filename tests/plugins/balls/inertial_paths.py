"""Made paths of a target that carries an inertial sensor: readings and positions whose truth is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot import Array, Context, Member, Room, Sensor, Target, at
from followspot.inertial import Inertial, Orientation, PosedTracks
from followspot.message_checks.sealing import seal
from followspot.rotation import canonical, from_rotation_vector, inverse, multiply, rotation_vector, turned
from followspot.tracking import Positions
from followspot_balls.inertial.stage import InertialFilter

RATE = 200.0
FINE = 0.001
"""Half the distance of the differences that give rates and accelerations, s."""
NANOSECONDS = 1e9
SENSOR = Sensor("imu", "imu", rate=RATE, mount=Member("targets", "red"))
ROOM = Room(targets={"red": Target("red", 0.05)}, sensors={"imu": SENSOR})


@dataclass(frozen=True, eq=False)
class Motion:
    """A target that rests and then moves on smooth random curves; arm: (3,) m, target minus sensor."""

    seed: int = 0
    still: float = 1.0
    arm: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def xyz(self, time: Array) -> Array:
        """Position of the target, (N, 3) m."""
        return np.array([0.5, -0.2, 1.2]) + self._curves(time, 0, 0.25)

    def quaternion(self, time: Array) -> Array:
        """Its orientation, (N, 4)."""
        tilt = from_rotation_vector(np.array([0.3, -0.2, 2.1]))
        return multiply(from_rotation_vector(self._curves(time, 1, 0.6)), tilt)

    def sensor(self, time: Array) -> Array:
        """Position of the sensor, (N, 3) m."""
        return self.xyz(time) - turned(self.quaternion(time), np.array(self.arm))

    def _curves(self, time: Array, which: int, size: float) -> Array:
        rng = np.random.default_rng((self.seed, which))
        rate, phase = rng.uniform(2.5, 6.0, (2, 3)), rng.uniform(0, 2 * np.pi, (2, 3))
        s = np.maximum(time - self.still, 0.0)[:, None, None]
        return np.asarray(size * (1 - np.exp(-np.square(s[..., 0]))) * np.sin(rate * s + phase).sum(axis=1))


@dataclass(frozen=True)
class Errors:
    """Errors of the made sensor and positions."""

    gyroscope_bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    accelerometer_bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gyroscope_noise: float = 1e-4
    accelerometer_noise: float = 2e-3
    position_noise: float = 0.003
    delay: float = 0.0
    drift: float = 0.0


def readings(
    motion: Motion,
    seconds: float,
    errors: Errors = Errors(),
    seed: int = 0,
    read_at: Callable[[Array], Array] = lambda time: time,
) -> list[Inertial]:
    """Messages of two readings each. read_at: when that is read which is sent at a time, s."""
    rng = np.random.default_rng(seed)
    sent = np.arange(round(seconds * RATE)) / RATE
    time = read_at(sent)
    q, later, before = (motion.quaternion(time + shift) for shift in (0.0, FINE, -FINE))
    rate = rotation_vector(multiply(inverse(before), later)) / (2 * FINE)
    bend = motion.sensor(time + FINE) - 2 * motion.sensor(time) + motion.sensor(time - FINE)
    force = turned(inverse(q), bend / FINE**2 + np.array([0.0, 0.0, 9.81]))
    rate += np.array(errors.gyroscope_bias) + errors.gyroscope_noise * np.sqrt(RATE) * rng.normal(
        size=rate.shape
    )
    force += np.array(errors.accelerometer_bias)
    force += errors.accelerometer_noise * np.sqrt(RATE) * rng.normal(size=rate.shape)
    once = np.maximum.accumulate(np.where(np.diff(time, prepend=-1.0) > 0, np.arange(len(time)), 0))
    rate, force = rate[once], force[once]
    stamp = np.rint((sent * (1 + errors.drift) + errors.delay) * NANOSECONDS).astype(np.int64)
    parts = [slice(i, i + 2) for i in range(0, len(time), 2)]
    unknown = np.full((2, 3), np.nan)
    return [
        seal(at(int(stamp[p][-1]), Inertial("imu", stamp[p], rate[p], force[p], unknown[: len(stamp[p])])))
        for p in parts
    ]


def orientations(motion: Motion, messages: Sequence[Inertial], heading: float = 1.0) -> list[Orientation]:
    """The true inclination with another heading, rad."""
    aside = from_rotation_vector(np.array([0.0, 0.0, heading]))
    found = []
    for message in messages:
        q = canonical(multiply(aside, motion.quaternion(message.time / NANOSECONDS)))
        sigma = np.full(len(q), 0.02)
        found.append(seal(at(message.header.time, Orientation("imu", message.time, q, sigma))))
    return found


def position(xyz: Array | None, time: float, noise: float = 0.003, predicted: bool = False) -> Positions:
    """The position of the only target, or none."""
    row: dict[str, Any] = {
        c.name: np.zeros([1 if isinstance(size, str) else size for size in c.shape], c.dtype)
        for c in Positions.columns
    }
    row |= {"xyz": np.zeros((1, 3)) if xyz is None else xyz[None], "covariance": np.eye(3)[None] * noise**2}
    row |= {"support": np.full(1, 9, np.int32), "confirmed": np.ones(1, bool)}
    message = Positions(**row | {"predicted": np.full(1, predicted)})
    message = message.where(slice(0)) if xyz is None else message
    return seal(at(round(time * NANOSECONDS), message))


@dataclass(frozen=True, eq=False)
class Run:
    """What the filter gave in M frames, and the truth: time (M,) s; xyz, truth (M, 3) m."""

    time: Array
    truth: Array
    orientation_truth: Array
    tracks: list[PosedTracks]

    @property
    def error(self) -> Array:
        """Distance from the truth, (M,) m; NaN without a position."""
        xyz = [t.xyz[0] if len(t.xyz) else np.full(3, np.nan) for t in self.tracks]
        return np.asarray(np.linalg.norm(np.array(xyz) - self.truth, axis=1))

    @property
    def turn_error(self) -> Array:
        """Angle of the error of the orientation, (M,) degrees; NaN without one."""
        q = np.array([t.quaternion[0] if len(t.xyz) else np.full(4, np.nan) for t in self.tracks])
        away = rotation_vector(multiply(q, inverse(self.orientation_truth)))
        return np.asarray(np.degrees(np.linalg.norm(away, axis=1)))


def filter_of(**params: Any) -> InertialFilter:
    """The stage in a room with one target that carries a sensor."""
    stage = InertialFilter(Context(name="track", room=ROOM), **params)
    stage.setup()
    return stage


def tracked(
    stage: InertialFilter,
    motion: Motion,
    seconds: float,
    *,
    errors: Errors = Errors(),
    rate: float = 60.0,
    hidden: Callable[[float], bool] = lambda t: False,
    late: Callable[[float], float] = lambda t: 0.0,
    lost: Callable[[float], bool] = lambda t: False,
    read_at: Callable[[Array], Array] = lambda time: time,
    moved: Callable[[float], Array] = lambda t: np.zeros(3),
    seed: int = 0,
    before: Callable[[int, InertialFilter], InertialFilter] = lambda n, stage: stage,
) -> Run:
    """Run the filter.

    hidden: frames without a position; late: s by which readings of a time arrive late; lost: readings that
    never arrive; read_at: when that is read which is sent at a time, s; moved: added to the positions, (3,)
    m; before: called before each frame, may replace the stage.
    """
    rng = np.random.default_rng((seed, 7))
    sent = readings(motion, seconds, errors, seed, read_at)
    turns = orientations(motion, sent)
    arriving = sorted(
        (m.header.time / NANOSECONDS + late(m.header.time / NANOSECONDS), n)
        for n, m in enumerate(sent)
        if not lost(m.header.time / NANOSECONDS)
    )
    time = np.arange(0.1, seconds - 0.1, 1 / rate)
    truth = motion.xyz(time)
    noisy = truth + errors.position_noise * rng.normal(size=truth.shape)
    found, due = [], 0
    for n, (t, xyz) in enumerate(zip(time, noisy, strict=True)):
        first = due
        while due < len(arriving) and arriving[due][0] <= t:
            due += 1
        new = sorted(number for _, number in arriving[first:due])
        stage = before(n, stage)
        seen = position(None if hidden(t) else xyz + moved(t), t)
        window = tuple(sent[k] for k in new), tuple(turns[k] for k in new)
        found.append(stage.process(seen, *window).tracks)
    return Run(time, truth, motion.quaternion(time), found)
