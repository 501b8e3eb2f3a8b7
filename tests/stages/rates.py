"""Stages for tests of streams with different rates. Loaded with --plugin."""

from __future__ import annotations

import threading
import time
import zlib
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future
from functools import partial
from itertools import accumulate
from typing import TextIO

import numpy as np

from followspot import (
    Array,
    Deferred,
    Field,
    Joined,
    Lagged,
    Latest,
    Message,
    Nearest,
    OutputPath,
    Outputs,
    Source,
    Stage,
    StageParams,
    Window,
    at,
    column,
)


class Reading(Message):
    """A number that a sensor read."""

    value: int


class Readings(Message):
    """Numbers and their capture times, ns."""

    values: Array = column("N", dtype="i8")
    times: Array = column("N", dtype="i8", unit="ns")


class Sensor(Stage):
    """Reads numbers from 0 on, in time with a clock of its own."""

    class Params(StageParams):
        hz: float = Field(1000.0, gt=0, description="readings per second", unit="Hz")
        count: int = Field(1000, ge=0, description="readings", unit="1")
        shift: float = Field(0.0, description="time of the first", unit="s")

    params: Params

    def length(self) -> int:
        return self.params.count

    def process(self) -> Source[Reading]:
        for n in range(self.params.count):
            yield at(round((n / self.params.hz + self.params.shift) * 1e9), Reading(n))


class Uneven(Stage):
    """Reads numbers after given pauses."""

    class Params(StageParams):
        pauses: list[int] = Field([], description="before each reading", unit="ms")

    params: Params

    def process(self) -> Source[Reading]:
        for n, time_ms in enumerate(accumulate(self.params.pauses)):
            yield at(time_ms * 1_000_000, Reading(n))


class Device(Sensor):
    """A sensor that reads while the run goes on."""

    live = True

    @classmethod
    def nominal_rate(cls, params: Sensor.Params) -> float:
        return params.hz

    def process(self) -> Source[Reading]:
        begun = time.monotonic()
        for n in range(self.params.count):
            due = begun + n / self.params.hz - time.monotonic()
            if due > 0 and not self.context.pause(due):
                return
            yield at(time.time_ns(), Reading(n))


class Gather(Stage):
    """The readings since the last frame."""

    def process(self, frame: Reading, readings: Window[Reading]) -> Readings:
        return _listed(readings)


class Near(Stage):
    """The reading nearest to a frame."""

    def process(self, frame: Reading, reading: Nearest[Reading]) -> Readings:
        return _listed(() if reading is None else (reading,))


class Meet(Stage):
    """A frame and the reading that belongs to it."""

    def process(self, frame: Reading, reading: Reading) -> Readings:
        return _listed((frame, reading))


class Together(Stage):
    """Readings of one time."""

    def process(self, readings: Joined[Reading]) -> Readings:
        return _listed(readings)


class Mix(Stage):
    """A digest of what it gets on inputs of all kinds."""

    def process(
        self,
        frame: Reading,
        other: Reading | None = None,
        window: Window[Reading] = (),
        near: Nearest[Reading] = None,
        latest: Latest[Reading] = None,
    ) -> Reading:
        got = [frame, other, near, latest, *window]
        text = repr([message and (message.header.time, message.value) for message in got])
        return Reading(zlib.crc32(text.encode()))


class Burst(Stage):
    """Several readings for one, each some time after the other."""

    class Params(StageParams):
        count: int = Field(3, ge=0, description="messages for each", unit="1")
        step_us: int = Field(100, description="time between two", unit="us")

    params: Params

    def process(self, reading: Reading) -> Outputs[Reading]:
        begin = reading.header.time
        for n in range(self.params.count):
            yield at(begin + 1000 * n * self.params.step_us, Reading(10 * reading.value + n))


class Spread(Stage):
    """Three readings for two that belong together, 1 ms apart."""

    def process(self, frame: Reading, reading: Reading) -> Outputs[Reading]:
        begin = min(frame.header.time, reading.header.time)
        return [at(begin + n * 1_000_000, Reading(n)) for n in range(3)]


class Later(Stage):
    """The same reading, after a while that differs from one to the next."""

    class Params(StageParams):
        longest_ms: int = Field(3, ge=0, description="longest while", unit="ms")

    params: Params

    def process(self, reading: Reading) -> Deferred[Reading]:
        return partial(self.answer, reading)

    def answer(self, reading: Reading) -> Reading | None:
        time.sleep(reading.value * 7 % (self.params.longest_ms + 1) / 1000)
        return Reading(reading.value + 1) if reading.value % 5 else None


class Silent(Stage):
    """Never answers."""

    def process(self, reading: Reading) -> Deferred[Reading]:
        return Future()


class Crowd(Stage):
    """The same reading, as soon as four are asked for at once."""

    def setup(self) -> None:
        self.barrier = threading.Barrier(4)

    def process(self, reading: Reading) -> Deferred[Reading]:
        def answer() -> Reading:
            self.barrier.wait(60)
            return reading

        return answer


class Behind(Stage):
    """Each reading, as many readings late as it is told; 0: all at the end."""

    class Params(StageParams):
        lag: int = Field(2, ge=0, description="readings", unit="1")

    params: Params

    def setup(self) -> None:
        self.kept: deque[Reading] = deque()

    def process(self, reading: Reading) -> Lagged[Reading]:
        self.kept.append(reading)
        return tuple(self.given(self.params.lag)) if self.params.lag else ()

    def remaining(self) -> Iterator[Reading]:
        return self.given(0)

    def given(self, kept: int) -> Iterator[Reading]:
        while len(self.kept) > kept:
            reading = self.kept.popleft()
            yield at(reading.header.time, Reading(10 * reading.value))


class Write(Stage):
    """Writes time, values and times of every message."""

    class Params(StageParams):
        path: OutputPath = Field("readings.csv", description="file to write")

    params: Params

    def setup(self) -> None:
        self.file: TextIO = (self.context.out / self.params.path).open("w")

    def process(self, readings: Readings) -> None:
        pairs = zip(readings.values.tolist(), readings.times.tolist(), strict=True)
        self.file.write(f"{readings.header.time}: {' '.join(f'{v}@{t}' for v, t in pairs)}\n")

    def close(self) -> None:
        self.file.close()


class Note(Write):
    """Writes time and value of every message."""

    def process(self, reading: Reading) -> None:  # type: ignore[override]
        self.file.write(f"{reading.header.time}: {reading.value}\n")


def _listed(readings: tuple[Reading, ...]) -> Readings:
    values = np.array([reading.value for reading in readings], np.int64)
    return Readings(values, np.array([reading.header.time for reading in readings], np.int64))
