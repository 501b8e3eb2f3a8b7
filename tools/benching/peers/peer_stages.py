"""Stages for tools/bench/runtime/peers.py: a camera that plays pictures, and a sink that notes tracks."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benching.peers.parts import Clock, Told, read_order, time_of
from followspot import Field, Source, Stage, StageParams, at
from followspot.tracking import Frame, Tracks


class OrderParams(StageParams):
    """The run's order."""

    order: Path = Field(description="the file of the order")


class Played(Stage):
    """Plays the pictures of a camera when they are due."""

    class Params(OrderParams):
        """See above."""

    params: Params
    per_camera = True

    def setup(self) -> None:
        self.order = read_order(str(self.params.order))
        self.clock = Clock(self.order)
        self.pictures = np.load(self.order.path(f"{self.camera.name}.npy"))
        self.clock.ready(self.camera.name)

    def process(self) -> Source[Frame]:
        self.clock.wait()
        for number in range(self.order.frames):
            due = self.clock.due(number) if self.order.rate else 0
            yield at(time_of(number), Frame(self.camera.name, self.pictures[number]), due=due)


class Noted(Stage):
    """Notes when tracks come, and which."""

    class Params(OrderParams):
        """See above."""

    params: Params

    def setup(self) -> None:
        self.told = Told(read_order(str(self.params.order)))

    def process(self, tracks: Tracks) -> None:
        self.told.tracks(tracks)

    def close(self) -> None:
        self.told.report()
