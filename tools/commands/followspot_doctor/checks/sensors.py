"""The first second of every sensor of a room, by the source that the room declares for it."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from followspot.errors import InputError
from followspot.inertial import Inertial
from followspot.messages import UNSTAMPED, Message
from followspot.room import Room, Sensor
from followspot.room_file import load
from followspot_doctor.checks.source import tried
from followspot_doctor.finding import Finding, doubtful, fine, wrong

MOST = 32
"""Sensors that are asked at once."""
MOST_READINGS = 2000
_LONGEST = 1.0
"""Time, s, for which readings are taken."""
_TOLERANCE = 0.2
"""Largest share by which the measured rate may differ from that of the room."""
_EXAMPLE = "source: {uses: imu.csv, with: {path: ...}}"


@dataclass(frozen=True)
class Readings:
    """kind: type of the messages; sensors: that they name; times: of the readings, ns."""

    kind: str
    sensors: frozenset[str]
    times: Sequence[int]

    @property
    def rate(self) -> float | None:
        """Rate of readings, 1/s; None if they are too few."""
        span = self.times[-1] - self.times[0] if len(self.times) > 1 else 0
        return (len(self.times) - 1) * 1e9 / span if span > 0 else None


def sensors(path: str) -> Iterator[Finding]:
    """One finding for each sensor; a room that cannot be read is reported with its cameras."""
    try:
        room = load(path)
    except InputError:
        return
    with ThreadPoolExecutor(MOST) as pool:
        yield from pool.map(lambda sensor: _sensor(sensor, room), room.sensors.values())


def _sensor(sensor: Sensor, room: Room) -> Finding:
    found = tried(sensor, room, _readings, _EXAMPLE)
    if found.finding is not None or sensor.source is None:
        return found.finding or wrong(sensor.name, "has no source", _EXAMPLE)
    uses = sensor.source.uses
    if found.taken is None:
        text = f"{uses} gave no reading in time: {found.said}"
        return wrong(sensor.name, text, "is it connected, switched on, and free of other programs?")
    return _judged(sensor, found.taken, uses)


def _judged(sensor: Sensor, readings: Readings, uses: str) -> Finding:
    others = sorted(readings.sensors - {sensor.name})
    if others:
        text = f"{uses} gives readings of {', '.join(others)}"
        return wrong(sensor.name, text, "name the sensor so in the room, or mend its source")
    if readings.rate is None:
        return fine(sensor.name, f"{uses}: {readings.kind}, {len(readings.times)} in {_LONGEST:g} s")
    text = f"{uses}: {readings.kind}, {readings.rate:.4g} readings/s"
    wanted = sensor.rate
    if wanted is not None and abs(readings.rate - wanted) > _TOLERANCE * wanted:
        remedy = f"rate: {readings.rate:.4g}, or set the sensor to {wanted:g}"
        return doubtful(sensor.name, f"{text}, and the room says {wanted:g}", remedy)
    return fine(sensor.name, text)


def _readings(messages: Iterator[Message]) -> Readings | None:
    """The readings of the first second, by their capture times, else by the times of their arrival."""
    times: list[int] = []
    names: set[str] = set()
    kind = ""
    end = time.monotonic() + _LONGEST
    for message in messages:
        kind = type(message).__name__
        named = getattr(message, "sensor", None)
        names |= {named} if isinstance(named, str) else set()
        if isinstance(message, Inertial):
            times += message.time.tolist()
        else:
            times.append(time.time_ns() if message.header == UNSTAMPED else message.header.time)
        full = len(times) >= MOST_READINGS or times[-1] - times[0] > _LONGEST * 1e9
        if full or time.monotonic() > end:
            break
    return Readings(kind, frozenset(names), times) if times else None
