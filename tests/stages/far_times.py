"""Stages for tests: messages with capture times and numbers as a parameter says. Loaded with --plugin."""

from __future__ import annotations

from collections.abc import Iterator

from followspot import Field, Message, Stage, StageParams, at
from followspot.messages import Header, stamped


class Tick(Message):
    """A number."""

    value: int


class Params(StageParams):
    """What the message claims."""

    time: int = Field(0, description="capture time", unit="ns")
    seq: int = Field(0, description="number of the frame", unit="1")


class At(Stage):
    """Yields one message at a time of its own."""

    Params = Params

    def process(self) -> Iterator[Tick]:
        yield at(self.params.time, Tick(1), seq=self.params.seq)


class Stamped(Stage):
    """As `At`, past the check of `at`."""

    Params = Params

    def process(self) -> Iterator[Tick]:
        yield stamped(Tick(1), Header("", self.params.seq, self.params.time))


class Last(Stage):
    """Remembers what came."""

    def process(self, tick: Tick) -> None:
        print(tick.header.time, tick.header.seq)
