"""Stages for tests that work together where they are alike. Loaded with --plugin."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import ClassVar, Self

from followspot import Field, Latest, Message, Source, Stage, StageParams, at

PERIOD = 10_000_000
"""Nanoseconds between two notes."""
SLOW = 0.2
"""Seconds that a note takes at a gate that is not open."""
PATIENCE = 60.0
"""Seconds after which a silent source gives up; no test that passes takes that long."""


class Note(Message):
    value: int


class Count(Stage):
    """Counts from 0; may leave one number out."""

    class Params(StageParams):
        count: int = Field(10, ge=0, description="numbers to yield", unit="1")
        skip: int = Field(-1, description="number to leave out", unit="1")

    params: Params

    def process(self) -> Source[Note]:
        for n in range(self.params.count):
            if n != self.params.skip:
                yield at(n * PERIOD, Note(n), seq=n)


class Double(Stage):
    """Doubles; together for less. May raise at one number: alone, together, or both."""

    class Params(StageParams):
        fault: str = Field("", description='"together", "few" (outputs), or else the stage that fails alone')
        at: int = Field(3, description="number at which to fail", unit="1")

    params: Params
    sizes: ClassVar[list[int]] = []
    """How many worked together, each time; tests clear it."""

    def process(self, note: Note, before: Latest[Note] = None) -> Note:
        if self.params.fault == self.context.name and note.value == self.params.at:
            raise ValueError(f"cannot double {note.value}")
        return Note(2 * note.value)

    @classmethod
    def process_together(
        cls, stages: Sequence[Self], inputs: Sequence[tuple[Note, Note | None]]
    ) -> list[Note]:
        cls.sizes.append(len(stages))
        if stages[0].params.fault == "together":
            raise RuntimeError("together we are lost")
        doubled = [stage.process(*arguments) for stage, arguments in zip(stages, inputs, strict=True)]
        return doubled[1:] if stages[0].params.fault == "few" else doubled


class Heard(Stage):
    """Passes on, and lets the silent source speak."""

    spoken: ClassVar[threading.Event]

    def process(self, note: Note) -> Note:
        self.spoken.set()
        return note


class Early(Stage):
    """A live source with one number."""

    live = True

    def process(self) -> Source[Note]:
        yield at(0, Note(1))


class Silent(Stage):
    """A live source that speaks only after what the other one said has come through."""

    live = True

    def process(self) -> Source[Note]:
        yield at(PERIOD, Note(2 if Heard.spoken.wait(PATIENCE) else -1))


class Triple(Double):
    """Cannot be set up."""

    def setup(self) -> None:
        raise ValueError("no tripling")


class Gate(Stage):
    """Lets notes pass one by one, slowly, from one of them on until it is opened."""

    class Params(StageParams):
        at: int = Field(0, description="number of the first that is slow", unit="1")

    params: Params
    reached: ClassVar[threading.Event]
    open: ClassVar[threading.Event]

    def process(self, note: Note) -> Note:
        if note.header.seq >= self.params.at:
            self.reached.set()
            self.open.wait(SLOW)
        return note


class Collect(Stage):
    """Keeps what it gets; tests clear it."""

    got: ClassVar[list[tuple[str, int, int]]] = []

    def process(self, note: Note) -> None:
        self.got.append((self.context.name, note.header.time // PERIOD, note.value))
