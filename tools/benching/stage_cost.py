"""CPU time of a frame set, of the whole graph and of each stage, over frames in memory.

Time is that of the process (`time.process_time`): other programs on the machine do not count.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benching.frames_in_memory import FromMemory, Shots, unsent
from benching.never_found import NeverFound
from followspot.graph.plan import Plan
from followspot.worker.build import build_worker
from followspot.worker.ledger import Ledger
from followspot.worker.runners.source import SourceRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.wiring import RunOptions, Wiring

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


@dataclass(frozen=True)
class Cost:
    """CPU time of one frame set, ms: of the whole graph, and of its stages by their name in the graph."""

    total: float
    stages: Mapping[str, float]
    tracked: float
    """Targets tracked, mean over the frame sets."""


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
            source.on_frame = watch.played
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
