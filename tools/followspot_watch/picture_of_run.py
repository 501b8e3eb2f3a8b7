"""A run's status for the page: stages and edges with rates."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from followspot.deploy.clocks.status import ClockStatus
from followspot.deploy.host import WorkerStatus
from followspot.deploy.status import RunStatus
from followspot.graph.plan import Plan, PlannedEdge
from followspot.runtime.ledger import EdgeCount
from followspot.runtime.stage_status import EdgeAge, PathStatus, StageStatus

_WINDOW = 2.0
"""Seconds over which rates are taken."""
_NEWS, _ERROR = 20, 2000
"""Most lines of news, and characters of an error, that are shown."""


class RunPicture:
    """The newest status, and how fast what it counts is growing.

    monotonic: a clock, s.
    """

    def __init__(self, plan: Plan, monotonic: Callable[[], float] = time.monotonic) -> None:
        self.plan = plan
        self.status: RunStatus | None = None
        self._clock = monotonic
        self._past: deque[tuple[float, dict[str, float]]] = deque()
        targets = {edge.to_stage for edge in plan.edges}
        self.sources = tuple(stage.name for stage in plan.stages if stage.name not in targets)

    def take(self, status: RunStatus) -> None:
        """A newer status."""
        now = self._clock()
        self.status = status
        self._past.append((now, self._growing(status)))
        while len(self._past) > 2 and now - self._past[1][0] >= _WINDOW:
            self._past.popleft()

    def workers(self) -> tuple[WorkerStatus, ...]:
        """All of them."""
        return self.status.workers if self.status else ()

    def stages(self) -> list[tuple[WorkerStatus, StageStatus]]:
        """All of them with their workers."""
        return [(w, stage) for w in self.workers() for stage in w.stages]

    def edges(self) -> list[tuple[PlannedEdge, EdgeCount]]:
        """All of them with their counts."""
        return list(self.status.edges(self.plan)) if self.status else []

    def paths(self) -> list[PathStatus]:
        """Latency from sources to sinks."""
        return [path for worker in self.workers() for path in worker.paths]

    def data(self) -> dict[str, Any]:
        """In JSON types; rates in 1/s, load as a share of one processor."""
        status = self.status
        rates = self._rates()
        ages = {age.name: age for _, stage in self.stages() for age in stage.edges}
        return {
            "type": "run",
            "fired": status.fired if status else 0,
            "expected": status.expected if status else None,
            "rate": max((rates.get(f"fired {name}", 0.0) for name in self.sources), default=0.0),
            "stages": [_stage(worker, stage, rates) for worker, stage in self.stages()],
            "edges": [_edge(edge, count, rates, ages) for edge, count in self.edges()],
            "paths": [asdict(path) for path in self.paths()],
            "news": list(status.news[-_NEWS:]) if status else [],
            "clocks": [_clock(host, clock) for host, clock in status.clocks.items()] if status else [],
        }

    def _growing(self, status: RunStatus) -> dict[str, float]:
        """Counters by name."""
        stages = [stage for worker in status.workers for stage in worker.stages]
        return {
            **{f"fired {stage.stage}": float(stage.fired) for stage in stages},
            **{f"busy {stage.stage}": stage.busy_ms for stage in stages},
            **{edge.name: float(count.sent) for edge, count in status.edges(self.plan)},
        }

    def _rates(self) -> Mapping[str, float]:
        """Growth of each counter, 1/s."""
        if len(self._past) < 2:
            return {}
        (start, old), (end, new) = self._past[0], self._past[-1]
        grown = {name: max(0.0, value - old.get(name, value)) for name, value in new.items()}
        return {name: round(growth / (end - start), 3) for name, growth in grown.items()}


def _clock(host: str, clock: ClockStatus) -> dict[str, Any]:
    return {"host": host, **asdict(clock), "warning": clock.warning}


def _stage(worker: WorkerStatus, stage: StageStatus, rates: Mapping[str, float]) -> dict[str, Any]:
    return {
        **asdict(stage),
        "worker": worker.name,
        "state": "absent" if worker.phase == "absent" else stage.state,
        "error": stage.error[:_ERROR],
        "edges": [age.name for age in stage.edges],
        "rate": rates.get(f"fired {stage.stage}", 0.0),
        "load": rates.get(f"busy {stage.stage}", 0.0) / 1000.0,
    }


def _edge(
    edge: PlannedEdge, count: EdgeCount, rates: Mapping[str, float], ages: Mapping[str, EdgeAge]
) -> dict[str, Any]:
    age = ages.get(edge.name, EdgeAge(edge.name, None, None))
    return {
        "from": f"{edge.from_stage}.{edge.from_port}",
        "to": f"{edge.to_stage}.{edge.to_port}",
        "kind": edge.way,
        "rate": rates.get(edge.name, 0.0),
        "p50_ms": age.p50_ms,
        "p95_ms": age.p95_ms,
        "error": age.error[:_ERROR],
        **asdict(count),
    }
