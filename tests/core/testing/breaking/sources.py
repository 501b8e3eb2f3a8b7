"""Sources that break a promise about their messages or times."""

from __future__ import annotations

import time

import numpy as np

from followspot import Field, Source, Stage, StageParams, at
from followspot.tracking import Blobs, Frame


class Stubborn(Stage):
    """Goes on when its generator is closed."""

    def process(self) -> Source[Blobs]:
        for number in range(1, 4):
            try:
                yield at(number, Blobs.empty())
            except GeneratorExit:
                yield at(4, Blobs.empty())


class HalfTimed(Stage):
    """Says times that are no whole numbers."""

    def process(self) -> Source[Blobs]:
        yield at(1.5, Blobs.empty())  # type: ignore[arg-type]


class Guessing(Stage):
    """Does not know its times."""

    def process(self) -> Source[Blobs]:
        yield at(1, Blobs.empty())

    def capture_time(self, number: int) -> int | None:
        raise LookupError


class Backwards(Stage):
    """Yields times that fall."""

    class Params(StageParams):
        start: int = Field(5, description="first time", unit="ns")

    params: Params

    def process(self) -> Source[Frame]:
        for n in range(self.params.start):
            yield at(self.params.start - n, Frame("cam0", np.zeros((1, 1, 1), np.uint8)))


class Misdated(Stage):
    """Tells other capture times than its messages have."""

    def capture_time(self, number: int) -> int:
        return number

    def process(self) -> Source[Frame]:
        for n in range(3):
            yield at(2 * n, Frame("cam0", np.zeros((1, 1, 1), np.uint8)))


class Unsteady(Stage):
    """Yields something else each time."""

    def process(self) -> Source[Frame]:
        for n in range(3):
            yield at(n, Frame("cam0", np.array([[[time.perf_counter_ns() % 251]]], np.uint8)))


class Undeclared(Stage):
    """Yields what it does not declare."""

    def process(self) -> Source[Frame]:
        yield at(0, Blobs.empty())  # type: ignore[misc]


class Timeless(Stage):
    """Yields without a capture time, though it is no device."""

    def process(self) -> Source[Blobs]:
        yield Blobs.empty()


class HashingSource(Stage):
    """Yields what depends on the hash of a text."""

    def process(self) -> Source[Frame]:
        name = next(iter(self.room.cameras))
        for n in range(4):
            yield at(n, Frame(name, np.full((4, 4, 1), hash(f"{name}{n}") % 251, np.uint8)))
