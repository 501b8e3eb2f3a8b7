"""Frames in memory, rendered or decoded before the clock starts: sources cost only the runtime's part."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from followspot.context import Context
from followspot.graph.plan import Plan
from followspot.messages import at
from followspot.plugins.registry import load_stage
from followspot.ports.marks import Source
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot.tracking import Frame

Shots = Mapping[str, Sequence[Frame]]
"""Frames of each camera."""


class FromMemory(Stage):
    """Plays frames that are there already.

    on_frame: called with the number of a frame before it is played.
    """

    frames: Sequence[Frame] = ()
    on_frame: Callable[[int], None]

    def process(self) -> Source[Frame]:
        """One after the other, each with its time."""
        for number, frame in enumerate(self.frames):
            self.on_frame(number)
            yield frame


def shots(plan: Plan, count: int) -> dict[str, list[Frame]]:
    """The first frames of all cameras of a plan, played by their own sources."""
    played = {}
    for stage in plan.stages:
        cls = load_stage(stage.uses)
        if stage.camera is not None and ports(cls).source:
            source = cls(Context(stage.name, plan.room, stage.member), **stage.params)
            source.setup()
            frames = (frame for frame, _ in zip(source.process(), range(count), strict=False))
            played[stage.camera] = [own(frame) for frame in frames]
            source.close()
    return played


def own(frame: Frame) -> Frame:
    """The frame in memory of its own; sources may use theirs again."""
    return at(frame.header.time, Frame(frame.camera, frame.pixels.copy()))


def unsent(frame: Frame) -> Frame:
    """The frame as a source first yields it."""
    return at(frame.header.time, Frame(frame.camera, frame.pixels))
