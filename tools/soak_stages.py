"""Stages for tools/soak.py: hosts that send beats, and where they meet. Loaded with --plugin."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path

import numpy as np

from followspot import Array, Field, Joined, Message, OutputPath, Source, Stage, StageParams, at, column

CLOCK = "clock"
"""File in a host's output folder with the ns by which its clock is wrong; none where it is right."""


class Beat(Message):
    """Which host is alive, and some load."""

    side: int
    load: Array = column("N", dtype="u1")


class Heart(Stage):
    """A live camera without a picture: it beats by the clock of its host."""

    class Params(StageParams):
        side: int = Field(0, ge=0, description="which host it is", unit="1")
        count: int = Field(1_000_000, ge=0, description="beats until it ends, like a camera file", unit="1")
        size: int = Field(10_000, ge=0, description="load of each beat", unit="1")

    params: Params
    live = True

    def setup(self) -> None:
        self.over = threading.Event()

    def close(self) -> None:
        self.over.set()

    def process(self) -> Source[Beat]:
        wrong = Path(self.context.out) / CLOCK
        for number in range(self.params.count):
            if self.over.wait(0.01):
                return
            shift = int(wrong.read_text() or 0) if wrong.exists() else 0
            beat = Beat(self.params.side, np.zeros(self.params.size, "u1"))
            yield at(time.time_ns() + shift, beat, seq=number)


class Meet(Stage):
    """Writes when it heard whom: monotonic time, s, and the sides. A full disk is an error each time."""

    class Params(StageParams):
        path: OutputPath = Field("beats.csv", description="file to write")

    params: Params

    def setup(self) -> None:
        path = self.context.out / self.params.path
        self.file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)

    def close(self) -> None:
        os.close(self.file)

    def process(self, beats: Joined[Beat]) -> None:
        sides = " ".join(str(beat.side) for beat in beats)
        line = f"\n{time.monotonic():.4f},{sides}"  # first the end of the last one, which may have been cut
        os.write(self.file, line.encode())
