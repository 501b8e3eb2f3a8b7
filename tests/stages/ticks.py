"""Stages for tests: numbers that tick, meet, fail, and are written down. Loaded with --plugin."""

from __future__ import annotations

import os
import signal
import threading
import time
from dataclasses import dataclass
from typing import TextIO

import numpy as np

from followspot import (
    Array,
    Field,
    Joined,
    Latest,
    Message,
    OutputPath,
    Source,
    Stage,
    StageParams,
    at,
    column,
)

PERIOD = 10_000_000
"""Nanoseconds between two ticks."""


class Tick(Message):
    """A number, and as many bytes as the test wants."""

    value: int
    load: Array = column("N", dtype="u1")


def tick(value: int, size: int = 0) -> Tick:
    return Tick(value, np.full(size, value % 256, dtype="u1"))


class Count(Stage):
    """Counts from 0; may stop short, shift its clock, leave numbers out, or raise."""

    class Params(StageParams):
        count: int = Field(10, ge=0, description="numbers to yield", unit="1")
        shift: int = Field(0, description="added to every capture time", unit="ns")
        size: int = Field(0, ge=0, description="bytes with every number", unit="1")
        skip: int = Field(0, ge=0, description="leave out every n-th number; 0 leaves none out", unit="1")
        raise_at: int = Field(-1, description="number at which to raise", unit="1")
        backwards_at: int = Field(-1, description="number whose time lies before the one before", unit="1")

    params: Params

    def length(self) -> int:
        return self.params.count

    def process(self) -> Source[Tick]:
        p = self.params
        for n in range(p.count):
            if n == p.raise_at:
                raise RuntimeError("the camera fell down")
            if p.skip and n % p.skip == p.skip - 1:
                continue
            back = 5 * PERIOD if n == p.backwards_at else 0
            yield at(n * PERIOD + p.shift - back, tick(n, p.size), seq=n)


class Fork(Count):
    """Counts, and forks when it is set up: the new process returns, too, unless it is tidy."""

    class Params(Count.Params):
        tidy: bool = Field(False, description="whether the new process ends")

    params: Params

    def setup(self) -> None:
        if not os.fork() and self.params.tidy:
            os._exit(0)


class Live(Stage):
    """Counts as fast as it can, like a device; stops when it is closed."""

    class Params(StageParams):
        count: int = Field(100, ge=0, description="numbers to yield", unit="1")
        period: float = Field(0.01, ge=0, description="time between two", unit="s")
        clock: bool = Field(True, description="whether it can tell the time")

    params: Params
    live = True

    def setup(self) -> None:
        self.over = threading.Event()

    def close(self) -> None:
        self.over.set()

    def process(self) -> Source[Tick]:
        for n in range(self.params.count):
            if self.over.wait(self.params.period):
                return
            yield at(time.time_ns(), tick(n), seq=n) if self.params.clock else tick(n)


class Add(Stage):
    """Adds a constant; may be slow, raise, break its contract or end its own process at one number."""

    class Params(StageParams):
        term: int = Field(1, description="added to every number", unit="1")
        sleep: float = Field(0.0, ge=0, description="time that it takes", unit="s")
        raise_at: int = Field(-1, description="number at which to raise", unit="1")
        invalid_at: int = Field(-1, description="number at which to return the wrong type", unit="1")
        kill_at: int = Field(-1, description="number at which to kill -9 the worker", unit="1")
        exit_at: int = Field(-1, description="number at which to end the process with code 0", unit="1")

    params: Params

    def process(self, number: Tick) -> Tick:
        p = self.params
        if p.sleep:
            time.sleep(p.sleep)
        if number.value == p.raise_at:
            raise ValueError(f"cannot add to {number.value}")
        if number.value == p.kill_at:
            os.kill(os.getpid(), signal.SIGKILL)
        if number.value == p.exit_at:
            os._exit(0)
        load = number.load.astype("f8") if number.value == p.invalid_at else number.load
        return Tick(number.value + p.term, load)


class Hold(Stage):
    """Keeps its first number until the file of another branch has so many lines: as slow as can be."""

    class Params(StageParams):
        path: str = Field("ticks.csv", description="the file, in the output folder")
        lines: int = Field(100, ge=0, description="lines to wait for", unit="1")

    params: Params
    holding = True

    def process(self, number: Tick) -> Tick:
        deadline = time.monotonic() + 30.0
        while self.holding and time.monotonic() < deadline:
            path = self.context.out / self.params.path
            self.holding = not path.exists() or len(path.read_text().splitlines()) < self.params.lines
            time.sleep(0.002)
        return number


class Counter(Stage):
    """Serves one number after the other, slowly, and tells how many it served while each waited in line."""

    class Params(StageParams):
        sleep: float = Field(0.005, ge=0, description="time that it takes", unit="s")

    params: Params

    def setup(self) -> None:
        self.begun: list[int] = []

    def process(self, number: Tick) -> Tick:
        entered = number.header.entered
        served = sum(1 for begun in reversed(self.begun) if begun > entered)
        self.begun.append(time.monotonic_ns())
        time.sleep(self.params.sleep)
        return tick(served)


class Odd(Stage):
    """Says nothing about even numbers."""

    def process(self, number: Tick) -> Tick | None:
        return number if number.value % 2 else None


class Sum(Stage):
    """Adds up what comes together."""

    def process(self, numbers: Joined[Tick]) -> Tick:
        return tick(sum(n.value for n in numbers))


class Both(Stage):
    """Needs two numbers of one time."""

    def process(self, left: Tick, right: Tick) -> Tick:
        return tick(left.value * 1000 + right.value)


@dataclass(frozen=True)
class Split:
    """Two outputs."""

    even: Tick | None
    odd: Tick | None


class Sort(Stage):
    """Even numbers to one port, odd ones to the other."""

    def process(self, number: Tick) -> Split:
        return Split(None, number) if number.value % 2 else Split(number, None)


class Accumulate(Stage):
    """Adds its own result of a while ago: a feedback loop."""

    def process(self, number: Tick, before: Latest[Tick] = None) -> Tick:
        return tick(number.value + (before.value if before is not None else 0))


class Tally(Stage):
    """Counts what comes, in steps; a successor counts on. May be unable to begin, or to carry on."""

    class Params(StageParams):
        step: int = Field(1, description="added at every number", unit="1")
        broken: bool = Field(False, description="whether it cannot be set up")
        forgetful: bool = Field(False, description="whether it cannot carry on")

    params: Params
    count = 0

    def setup(self) -> None:
        if self.params.broken:
            raise RuntimeError("the model is missing")

    def process(self, number: Tick) -> Tick:
        self.count += self.params.step
        return tick(self.count)

    def state(self) -> dict[str, int]:
        return {"count": self.count}

    def restore(self, state: dict[str, int]) -> None:
        if self.params.forgetful:
            raise KeyError("count")
        self.count = state["count"]


class Swapped(Stage):
    """As `Add`, with its inputs in another order and one more."""

    def process(self, before: Latest[Tick] = None, number: Tick = None) -> Tick:  # type: ignore[assignment]
        assert before is None
        return Tick(number.value + 5000, number.load)


class Hoard(Stage):
    """Keeps every message, and says at the end of each whether all still hold what they held."""

    def setup(self) -> None:
        self.kept: list[Tick] = []

    def process(self, number: Tick) -> Tick:
        self.kept.append(number)
        whole = all((kept.load == kept.value % 256).all() for kept in self.kept)
        return tick(len(self.kept) if whole else -1)


class Write(Stage):
    """Writes source, number, time and value of every message."""

    class Params(StageParams):
        path: OutputPath = Field("ticks.csv", description="file to write")

    params: Params

    def setup(self) -> None:
        self.file: TextIO = (self.context.out / self.params.path).open("w", buffering=1)

    def process(self, number: Tick) -> None:
        h = number.header
        self.file.write(f"{h.seq},{h.time},{number.value},{number.load.sum()}\n")

    def close(self) -> None:
        self.file.close()
