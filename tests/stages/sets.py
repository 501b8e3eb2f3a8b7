"""Stages for tests that make sets of messages, each in another way. Loaded with --plugin."""

from __future__ import annotations

import time
from collections import deque
from itertools import count

from followspot import Joined, Lagged, Message, Nearest, Outputs, Source, Stage, StageParams, at

PERIOD = 10_000_000
"""Nanoseconds between two notes."""


class Note(Message):
    """A number, and how many notes it was made of."""

    number: int
    members: int


class Count(Stage):
    """Counts from 0 without end, five times as fast as its clock, which may be shifted."""

    class Params(StageParams):
        shift: int = 0

    params: Params

    def process(self) -> Source[Note]:
        begun = time.monotonic_ns()
        for number in count():
            moment = number * PERIOD + self.params.shift
            yield at(moment, Note(number, 1), due=begun + moment // 5)


class Pass(Stage):
    """Passes notes on."""

    class Params(StageParams):
        label: int = 0

    params: Params

    def process(self, note: Note) -> Note:
        return note


class Pair(Stage):
    """The notes of a set as one."""

    def process(self, notes: Joined[Note]) -> Note:
        return Note(min(note.number for note in notes), len(notes))


class Several(Stage):
    """The notes of a set as one, among several results."""

    def process(self, notes: Joined[Note]) -> Outputs[Note]:
        return [Note(min(note.number for note in notes), len(notes))]


class Near(Stage):
    """The number of one note, and whether another is near."""

    def process(self, note: Note, other: Nearest[Note]) -> Note:
        return Note(note.number, 1 + (other is not None))


class Late(Stage):
    """Passes notes on, with the third firing after them."""

    def setup(self) -> None:
        self.waiting: deque[tuple[int, Note]] = deque()

    def process(self, note: Note) -> Lagged[Note]:
        self.waiting.append((note.header.time, Note(note.number, note.members)))
        return [at(*self.waiting.popleft())] if len(self.waiting) > 3 else []

    def remaining(self) -> Lagged[Note]:
        return [at(time, note) for time, note in self.waiting]
