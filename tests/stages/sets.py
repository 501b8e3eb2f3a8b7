"""Stages for tests that make sets of messages, each in another way. Loaded with --plugin."""

from __future__ import annotations

import threading
import time
from collections import deque
from itertools import count

from followspot import (
    Joined,
    Lagged,
    Latest,
    Message,
    Nearest,
    Outputs,
    Source,
    Stage,
    StageParams,
    Window,
    at,
)

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


class Device(Stage):
    """A live source of four notes; a later one waits for a file in the output folder, `go` and its number."""

    class Params(StageParams):
        first: int = 1
        """Notes that come at once."""

    params: Params
    live = True

    def setup(self) -> None:
        self.over = threading.Event()

    def close(self) -> None:
        self.over.set()

    def process(self) -> Source[Note]:
        for number in range(4):
            while number >= self.params.first and not (self.context.out / f"go{number}").exists():
                if self.over.wait(0.01):
                    return
            yield at(number * PERIOD, Note(number, 1))


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


class Recent(Stage):
    """Passes notes on, with feedback and with all notes of another stream."""

    def process(self, note: Note, before: Latest[Note] = None, beside: Window[Note] = ()) -> Note:
        return note


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
