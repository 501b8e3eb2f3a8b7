"""Shared parts of benchmarks: frames in memory, a tracker that never finds, and CPU time by stage.

Frames are rendered or decoded before the clock starts, so sources cost nothing but the runtime's part.
Time is that of the process (`time.process_time`): other programs on the machine do not count.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from followspot.context import Context
from followspot.graph.plan import Plan
from followspot.messages import at
from followspot.plugins.registry import load_stage
from followspot.ports.marks import Source
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot.tracking import LOST, Forecast, Frame, Positions, Tracks
from followspot.worker.build import build_worker
from followspot.worker.ledger import Ledger
from followspot.worker.runners.source import SourceRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.wiring import RunOptions, Wiring

Shots = Mapping[str, Sequence[Frame]]
"""Frames of each camera."""
TRACKER = "track"
"""Stage that forecasts places of targets."""


class Stopwatch:
    """CPU time of the process from frame set `lead` on; the first ones find the targets.

    began: called when that frame set begins.
    """

    def __init__(self, lead: int, began: Callable[[], None] | None = None) -> None:
        self.lead = lead
        self.began = began
        self.busy: dict[str, int] = defaultdict(int)
        """CPU time of each stage, ns."""
        self.tracked = 0
        """Targets tracked, over all frame sets."""
        self.started: float | None = None
        """CPU time of the process when that frame set began, s."""

    def played(self, number: int) -> None:
        """A source plays this frame; the work on all before it is done."""
        if number == self.lead and self.started is None:
            self.busy.clear()
            self.tracked = 0
            if self.began is not None:
                self.began()
            self.started = time.process_time()

    def seconds(self) -> float:
        """CPU time of the process so far. Raises ValueError if the frames ended first."""
        if self.started is None:
            raise ValueError(f"there are no frames after the first {self.lead}, which are not measured")
        return time.process_time() - self.started


class FromMemory(Stage):
    """Plays frames that are there already."""

    frames: Sequence[Frame] = ()
    watch: Stopwatch

    def process(self) -> Source[Frame]:
        """One after the other, each with its time."""
        for number, frame in enumerate(self.frames):
            self.watch.played(number)
            yield frame


@dataclass(frozen=True)
class Found:
    """A tracker's outputs."""

    tracks: Tracks
    forecast: Forecast


class NeverFound(Stage):
    """A tracker that believes nothing, so that all targets are sought in whole images for ever."""

    def process(self, positions: Positions) -> Found:
        """No track, and a forecast in which all targets are lost."""
        count = len(self.room.targets)
        nowhere = np.zeros((count, 3))
        lost = Forecast(
            period=0.0,
            state=np.full(count, LOST, np.uint8),
            xyz=nowhere,
            velocity=nowhere,
            covariance=np.zeros((count, 3, 3)),
            last=nowhere,
            before=nowhere,
        )
        return Found(Tracks.empty(), lost)


@dataclass(frozen=True)
class Cost:
    """CPU time of one frame set, ms: of the whole graph, and of its stages by their name in the graph."""

    total: float
    stages: Mapping[str, float]
    tracked: float
    """Targets tracked, mean over the frame sets."""


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


def measure(
    plan: Plan,
    played: Shots,
    out: Path,
    *,
    frames: int | None = None,
    lead: int = 0,
    searching: bool = False,
    by_stage: bool = True,
    began: Callable[[], None] | None = None,
) -> Cost:
    """Run a plan of one worker over frames in memory. Raises StageError, and ValueError for too few frames.

    frames: at most; lead: frame sets before the clock starts; searching: no target is ever found; by_stage:
    whether each stage is clocked, which costs a microsecond or two a call; began: called as the clock starts.
    """
    ledger = Ledger(len(plan.edges))
    scheduler = build_worker(Wiring(plan), plan.workers[0].name, ledger, RunOptions(out, frames))
    watch = Stopwatch(lead, began)
    for stage, runner in zip(plan.stages, scheduler.runners, strict=True):
        if isinstance(runner, SourceRunner) and stage.camera is not None:
            source = FromMemory(runner.stage.context)
            source.frames = [unsent(frame) for frame in played[stage.camera]]
            source.watch = watch
            runner.stage = source
            continue
        if stage.name == TRACKER and searching:
            runner.stage = NeverFound(runner.stage.context)
        if by_stage:
            _clocked(runner, stage.group, watch.busy)
        if stage.name == TRACKER:
            _counted(runner, watch)
    scheduler.setup()
    scheduler.run()
    seconds = watch.seconds()
    sets = max(source.yielded for source in scheduler.sources.all) - lead
    stages = {name: ns / 1e6 / sets for name, ns in watch.busy.items()}
    return Cost(seconds * 1e3 / sets, stages, watch.tracked / sets)


def _clocked(runner: StageRunner, name: str, busy: dict[str, int]) -> None:
    """Add up the CPU time of a stage, ns; for stages in a batch group, that of their common call."""
    work = "process" if runner.stage.process_together is None else "process_together"
    process: Callable[..., Any] = getattr(runner.stage, work)

    def clocked(*arguments: Any) -> Any:
        started = time.process_time_ns()
        result = process(*arguments)
        busy[name] += time.process_time_ns() - started
        return result

    setattr(runner.stage, work, clocked)


def _counted(runner: StageRunner, watch: Stopwatch) -> None:
    """Count the targets that a tracker says it tracks."""
    process: Callable[..., Any] = runner.stage.process

    def counted(*arguments: Any) -> Any:
        result = process(*arguments)
        watch.tracked += len(result.tracks.target)
        return result

    runner.stage.process = counted
