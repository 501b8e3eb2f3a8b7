"""Simulated balls that are hidden for a while, with pictures and without. Loaded with --plugin."""

from __future__ import annotations

import numpy as np

from followspot import Field, Outputs, Source, Stage, StageParams, at
from followspot.inertial import Inertial
from followspot.tracking import Frame, Positions
from followspot_sim.parameters import SimParams
from followspot_sim.truth import SimTruth

SIGMA = 0.003
"""Of a position along each axis, m."""


class SeenParams(SimParams):
    """The performance, and when balls are hidden."""

    begin: float = Field(9.0, unit="s", description="first time of hiding")
    duration: float = Field(1.0, unit="s", description="length of hiding")
    period: float = Field(4.0, unit="s", description="from one hiding to the next")


class Seen(Stage):
    """What a fusion gives for the balls that cameras can see; all are hidden again and again."""

    class Params(SeenParams):
        """The performance, and when balls are hidden."""

    params: Params

    def setup(self) -> None:
        own = self.params.model_dump(include=set(SimParams.model_fields))
        self.truth = SimTruth(self.context, **own)
        self.truth.setup()

    def process(self) -> Source[Positions]:
        for frame in range(self.params.frames):
            yield at(round(frame * 1e9 / self.params.fps), self.positions(frame), seq=frame)

    def positions(self, frame: int) -> Positions:
        p, truth, now = self.params, self.truth.truth(frame), frame / self.params.fps
        hidden = now >= p.begin and (now - p.begin) % p.period < p.duration
        seen = truth.trackable & (not hidden)
        names = list(self.room.targets)
        target = np.array([names.index(name) for name in truth.objects], "i4")[seen]
        count = len(target)
        return Positions(
            target=target,
            xyz=truth.xyz[seen] + self.rng.normal(0, SIGMA, (count, 3)),
            covariance=np.tile(SIGMA**2 * np.eye(3), (count, 1, 1)),
            support=np.full(count, 3, "i4"),
            confirmed=np.ones(count, bool),
            evident=np.ones(count, bool),
            iterations=np.zeros(count, "i4"),
            predicted=np.zeros(count, bool),
        )


class Curtain(Stage):
    """A black curtain before a camera for a while."""

    class Params(StageParams):
        """When it is closed."""

        begin: float = Field(5.0, unit="s", description="time at which it closes")
        duration: float = Field(1.0, unit="s", description="time until it opens again")

    params: Params

    def process(self, frame: Frame) -> Frame:
        closed = 0 <= frame.header.time * 1e-9 - self.params.begin < self.params.duration
        return Frame(frame.camera, np.zeros_like(frame.pixels) if closed else frame.pixels)


class Belated(Stage):
    """A bad link: messages come late by a delay that varies, none is lost."""

    class Params(StageParams):
        """The link."""

        least_delay: float = Field(0.03, unit="s", description="of a message")
        most_delay: float = Field(0.12, unit="s", description="of a message")

    params: Params

    def setup(self) -> None:
        self.last = 0

    def process(self, readings: Inertial) -> Outputs[Inertial]:
        delay = self.rng.uniform(self.params.least_delay, self.params.most_delay)
        self.last = max(readings.header.time + round(delay * 1e9), self.last + 1)
        columns = {name: getattr(readings, name) for name in readings.array_names}
        yield at(self.last, Inertial(readings.sensor, **columns))
