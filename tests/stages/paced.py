"""Stages for tests: a source whose messages have a time before which they are not sent."""

from __future__ import annotations

import time

from followspot import Field, Message, Source, Stage, StageParams, at

PERIOD = 10_000_000
HOUR = 3600 * 10**9


class Paced(Message):
    """A number, and when it may be sent, ns of the monotonic clock."""

    value: int
    due: int


class Pace(Stage):
    """Counts; each number may be sent a while after the one before."""

    class Params(StageParams):
        count: int = Field(5, ge=0, description="numbers to yield", unit="1")
        interval: int = Field(20_000_000, ge=0, description="time between two", unit="ns")
        waits_at: int = Field(-1, description="number that waits for an hour", unit="1")

    params: Params

    def process(self) -> Source[Paced]:
        begun = time.monotonic_ns()
        for n in range(self.params.count):
            due = begun + (HOUR if n == self.params.waits_at else n * self.params.interval)
            yield at(n * PERIOD, Paced(n, due), seq=n, due=due)


class Punctual(Stage):
    """Fails if a number comes too early."""

    def process(self, number: Paced) -> None:
        if time.monotonic_ns() < number.due:
            raise RuntimeError(f"{number.value} came early")


class Begun(Stage):
    """Says since when a source that plays at a pace counts."""

    def process(self) -> Source[Paced]:
        yield at(0, Paced(0, self.context.begun()))


class Together(Stage):
    """Fails if two sources do not count from the same moment."""

    def process(self, left: Paced, right: Paced) -> None:
        if left.due != right.due:
            raise RuntimeError(f"{left.due} is not {right.due}")
