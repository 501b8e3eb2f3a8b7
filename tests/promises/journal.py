"""Stages that keep journals: a line for every message before they hand it out, and when they are given it.

Loaded with --plugin. A line is the id of the process, the stage that made the message, and the message's
number, which no other message of that stage has. It is written with one call that appends, so that it is
there whatever happens to the process a moment later. Nothing here looks at the ledger or uses what keeps it.
"""

from __future__ import annotations

import itertools
import os
import threading
import time
from dataclasses import dataclass

import numpy as np

import followspot as fs


class Note(fs.Message):
    """A number, its maker, and some bytes: with enough of them it travels in a slot of a ring."""

    value: int
    by: str
    load: fs.Array = fs.column("N", dtype="u1")


class Keeper:
    """Knows where to write: the environment has the folder of the journals."""

    context: fs.Context

    def setup(self) -> None:
        self.journals = os.environ["JOURNALS"]
        self.files: dict[str, int] = {}

    def write(self, what: str, note: Note) -> None:
        """Append a line to the journal of a port; what: in.PORT or out.PORT."""
        if what not in self.files:
            name = f"{self.context.name.replace('/', '~')}.{what}"
            flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
            self.files[what] = os.open(os.path.join(self.journals, name), flags, 0o600)  # noqa: PTH118
        os.write(self.files[what], f"{os.getpid()} {note.by} {note.value}\n".encode())

    def got(self, note: Note, port: str = "note") -> None:
        self.write(f"in.{port}", note)

    def made(self, value: int, load: fs.Array, port: str = "out") -> Note:
        note = Note(value, self.context.name, load)
        self.write(f"out.{port}", note)
        return note

    def asked(self, what: str) -> bool:
        """Whether a file asks this stage to misbehave."""
        return os.path.exists(os.path.join(self.journals, f"{what}.{self.context.name}"))  # noqa: PTH110, PTH118

    def linger(self) -> None:
        if self.asked("slow"):
            time.sleep(0.03)


class CameraParams(fs.StageParams):
    """How a camera runs."""

    period: float = fs.Field(0.01, ge=0, description="time between two", unit="s")
    size: int = fs.Field(0, ge=0, description="bytes with every number", unit="1")
    count: int = fs.Field(1_000_000_000, ge=0, description="numbers to give", unit="1")


class Camera(Keeper, fs.Stage):
    """A live source."""

    Params = CameraParams
    params: CameraParams
    live = True

    def setup(self) -> None:
        super().setup()
        self.over = threading.Event()

    def close(self) -> None:
        self.over.set()

    def process(self) -> fs.Source[Note]:
        for n in range(self.params.count):
            if self.over.wait(self.params.period):
                return
            when = time.time_ns()
            yield fs.at(when, self.made(when, np.full(self.params.size, n % 256, "u1")), seq=n)


class Film(Keeper, fs.Stage):
    """A source that waits for its readers; it gives more than its count as long as it is asked to."""

    Params = CameraParams
    params: CameraParams

    def process(self) -> fs.Source[Note]:
        for n in itertools.count():
            if n >= self.params.count and not self.asked("more"):
                return
            yield fs.at(
                n * 10_000_000, self.made(time.time_ns(), np.full(self.params.size, n % 256, "u1")), seq=n
            )


class StepParams(fs.StageParams):
    """What a step does beside its work."""

    invalid_every: int = fs.Field(
        0, ge=0, description="break the contract at every so many numbers", unit="1"
    )


class Step(Keeper, fs.Stage):
    """Passes on what it gets."""

    Params = StepParams
    params: StepParams

    def process(self, note: Note) -> Note:
        self.got(note)
        self.linger()
        every = self.params.invalid_every
        invalid = every and note.header.seq % every == 0
        return self.made(note.value, note.load.astype("f8") if invalid else note.load)


class Sampling(Keeper, fs.Stage):
    """Passes on what it gets, and looks at what was last known of something else."""

    last = -1

    def process(self, note: Note, known: fs.Latest[Note] = None) -> Note:
        self.got(note)
        if known is not None and known.by and known.value != self.last:
            self.last = known.value
            self.got(known, "known")
        self.linger()
        return self.made(note.value, note.load)


@dataclass(frozen=True)
class Halves:
    """Two outputs."""

    even: Note | None
    odd: Note | None


class Split(Keeper, fs.Stage):
    """Even numbers to one port, odd ones to the other."""

    def process(self, note: Note) -> Halves:
        self.got(note)
        self.linger()
        if note.header.seq % 2:
            return Halves(None, self.made(note.value, note.load, "odd"))
        return Halves(self.made(note.value, note.load, "even"), None)


class Meet(Keeper, fs.Stage):
    """Takes what comes together."""

    def process(self, notes: fs.Joined[Note]) -> Note:
        for note in notes:
            self.got(note, "notes")
        self.linger()
        return self.made(notes[0].value, notes[0].load)


class SaveParams(fs.StageParams):
    """Where to."""

    path: fs.OutputPath = fs.Field("notes.csv", description="file to write")


class Save(Keeper, fs.Stage):
    """Writes every message to a disk, which may be full."""

    Params = SaveParams
    params: SaveParams

    def setup(self) -> None:
        super().setup()
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        self.file = os.open(self.context.out / self.params.path, flags, 0o600)
        self.full = os.open("/dev/full", os.O_WRONLY)

    def close(self) -> None:
        os.close(self.file)
        os.close(self.full)

    def process(self, note: Note) -> None:
        self.got(note)
        self.linger()
        os.write(self.full if self.asked("full") else self.file, f"{note.value}\n".encode())


class Sick(Keeper, fs.Stage):
    """Cannot be set up."""

    def setup(self) -> None:
        raise RuntimeError("the model is missing")

    def process(self, note: Note) -> Note:
        return note
