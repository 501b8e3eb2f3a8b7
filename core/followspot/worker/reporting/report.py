"""The report of a worker that has ended, and the warnings of its stages."""

from __future__ import annotations

from collections.abc import Callable

from followspot.control.worker_report import RUN_AGAIN, StageReport, WorkerReport
from followspot.errors import printable_lines
from followspot.worker.runners.source import SourceRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler

MAX_WARNINGS = 200
"""Different warnings kept per worker; further ones are only counted."""


class Warnings:
    """Collects the warnings of stages, equal ones once; tell: gets stage and text of each."""

    def __init__(self, log: Callable[[str, str], None] = lambda stage, text: None) -> None:
        self._log = log
        self._counts: dict[str, int] = {}
        self._more = 0
        self.last: dict[str, str] = {}
        """The newest of each stage."""

    def add(self, stage: str, text: str) -> None:
        """A stage's warning, which may repeat what others sent; safe from any thread."""
        text = printable_lines(text)
        self.last[stage] = text
        self._log(stage, text)
        line = f"{stage}: {text}"
        if line in self._counts or len(self._counts) < MAX_WARNINGS:
            self._counts[line] = self._counts.get(line, 0) + 1
        else:
            self._more += 1

    def begin(self, stage: str) -> None:
        """A stage begins: the newest warning was of another one of its name."""
        self.last.pop(stage, None)

    def lines(self) -> tuple[str, ...]:
        """The texts, with how often each was said."""
        lines = [text + (f" ({count} times)" if count > 1 else "") for text, count in self._counts.items()]
        return (*lines, f"{self._more} more warnings") if self._more else tuple(lines)


def worker_report(name: str, scheduler: Scheduler, warnings: Warnings, error: str = "") -> WorkerReport:
    """The report of a worker that has ended, one way or the other."""
    for queue in scheduler.ends.readers:
        if queue.invalid_reason:
            warnings.add(queue.name, f"invalid message: {queue.invalid_reason}")
    return WorkerReport(
        name,
        max((s.yielded for s in scheduler.sources.all if not s.accompanying), default=0),
        tuple(map(stage_report, scheduler.runners)),
        tuple(path.summary(origin, c.name) for c in scheduler.runners for origin, path in c.paths.items()),
        warnings.lines(),
        error,
    )


def stage_report(runner: StageRunner) -> StageReport:
    """The figures of one stage."""
    count = runner.count
    figures = (runner.name, count.fired, count.skipped, count.restarts, count.busy_ns / 1e6)
    if isinstance(runner, SourceRunner):
        return StageReport(*figures, time=runner.watermark, exhausted=runner.exhausted)
    return StageReport(*figures)


def missing(scheduler: Scheduler) -> str:
    """The error that it is in a replay if messages were lost on their way to the worker; "" for none."""
    lost = [f"{queue.name}: {queue.missing} messages" for queue in scheduler.ends.readers if queue.missing]
    return f"{', '.join(lost)} were lost on their way; {RUN_AGAIN}" if lost else ""
