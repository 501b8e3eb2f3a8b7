"""Stages for tools/bench/runtime/hosts.py: a camera and readers of its pictures. Loaded with --plugin."""

from __future__ import annotations

import threading
import time

import numpy as np

from followspot import Field, Joined, Source, Stage, StageParams, at
from followspot.tracking import Frame

FIRST = "first"
"""File that says that the first pictures are here."""


class Film(Stage):
    """A live camera with smooth pictures and a little noise, as pictures of rooms are."""

    class Params(StageParams):
        rate: float = Field(60.0, gt=0, description="pictures a second", unit="Hz")
        count: int = Field(120, ge=0, description="pictures until it ends", unit="1")
        width: int = Field(320, ge=16, description="of a picture", unit="px")
        height: int = Field(240, ge=16, description="of a picture", unit="px")

    params: Params
    live = True

    def setup(self) -> None:
        self.over = threading.Event()
        p = self.params
        slope = np.add.outer(np.arange(p.height), np.arange(p.width)) * (200 / (p.height + p.width))
        noise = np.random.default_rng(0).normal(0.0, 2.0, (p.height, p.width, 3))
        self.pixels = np.clip(slope[:, :, None] + 20 + noise, 0, 255).astype("u1")

    def close(self) -> None:
        self.over.set()

    def process(self) -> Source[Frame]:
        begun = time.monotonic()
        for number in range(self.params.count):
            if self.over.wait(max(0.0, begun + number / self.params.rate - time.monotonic())):
                return
            yield at(time.time_ns(), Frame("film", self.pixels), seq=number)


class Look(Stage):
    """Takes pictures of one camera; the run measures how old they are. Notes that the first is here."""

    noted = False

    def process(self, frame: Frame) -> None:
        """Once is enough."""
        if not self.noted:
            self.noted = True
            (self.context.out / FIRST).write_text("picture\nhere\n")


class LookAtAll(Stage):
    """Takes pictures of all cameras as they come together. Notes that one of each has been here."""

    class Params(StageParams):
        cameras: int = Field(1, ge=1, description="cameras to be heard", unit="1")

    params: Params

    def setup(self) -> None:
        self.heard: set[str] = set()

    def process(self, frames: Joined[Frame]) -> None:
        """A late camera may be missing."""
        if len(self.heard) < self.params.cameras:
            self.heard |= {frame.header.source for frame in frames}
            if len(self.heard) == self.params.cameras:
                (self.context.out / FIRST).write_text("pictures\nhere\n")
