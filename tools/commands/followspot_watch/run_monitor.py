"""A run's status with rates: stages, edges, and the age of what hosts and workers reported last."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Container, Mapping
from dataclasses import asdict, replace
from typing import Any, NamedTuple

from followspot.errors import FollowspotError
from followspot.graph.plan import Plan, PlannedEdge
from followspot.library.handle import (
    COUNTS,
    OLD,
    SOURCE_LOSSES,
    ClockStatus,
    EdgeAge,
    EdgeCount,
    NoAnswer,
    PathStatus,
    RunStatus,
    StageState,
    StageStatus,
    WorkerStatus,
    is_old,
    is_stale,
)

_WINDOW = 2.0
"""Seconds over which a rate is measured."""
_NEWS, _ERROR = 20, 2000
"""Lines of news and characters of an error at most."""


class RunMonitor:
    """The newest status of a run, and the rates of its counters.

    monotonic: clock, s.
    """

    def __init__(self, plan: Plan, monotonic: Callable[[], float] = time.monotonic) -> None:
        self.plan = plan
        self._status: RunStatus | None = None
        self._clock = monotonic
        self._taken = monotonic()
        self.ended = False
        self._past: deque[tuple[float, Mapping[str, _Count]]] = deque()
        targets = {edge.to_stage for edge in plan.edges}
        self.sources = tuple(stage.name for stage in plan.stages if stage.name not in targets)

    def take(self, status: RunStatus) -> None:
        """Keep a newer status."""
        self._status, self._taken = status, self._clock()
        now = self._taken
        self._past.append((now, self._growing(status, now)))
        while len(self._past) > 2 and now - self._past[1][0] >= _WINDOW:
            self._past.popleft()

    def renew(self, ask: Callable[[], RunStatus]) -> None:
        """Take the status that `ask` returns. If the run does not answer, its last status ages."""
        try:
            self.take(ask())
        except NoAnswer:
            return
        except FollowspotError:
            self.ended = True

    @property
    def age_s(self) -> float:
        """Seconds since the last answer of the run; 0 after its end."""
        return 0.0 if self.ended else self._clock() - self._taken

    @property
    def status(self) -> RunStatus | None:
        """The newest status with its present age; None before the first."""
        return None if self._status is None else self._status.later(self.age_s)

    def faults(self) -> tuple[str, ...]:
        """A line for the run if it is silent, then one for each host or worker that is absent or silent."""
        known = () if self._status is None else self._status.faults()
        return (f"the run has not answered for {self.age_s:.0f} s", *known) if self.age_s > OLD else known

    def workers(self) -> tuple[WorkerStatus, ...]:
        """All workers."""
        return self.status.workers if self.status else ()

    def stages(self) -> list[tuple[WorkerStatus, StageStatus]]:
        """All stages of the plan with their workers, in the last known states."""
        workers = {worker.name: worker for worker in self.workers()}
        latest = sorted(
            workers.values(), key=lambda worker: worker.phase != "over"
        )  # a moved stage is known to two workers
        reported = {stage.stage: (worker, stage) for worker in latest for stage in worker.stages}
        found = []
        for planned in self.plan.stages:
            if planned.name in reported:
                found.append(reported.pop(planned.name))
            elif planned.worker in workers:  # else another operator runs it
                found.append((workers[planned.worker], StageStatus(planned.name, "starting")))
        found += reported.values()  # the plan may be older than a move
        return [(worker, replace(stage, state=_state(worker, stage))) for worker, stage in found]

    def edges(self) -> list[tuple[PlannedEdge, EdgeCount]]:
        """All edges with their counts."""
        return list(self._status.edges(self.plan)) if self._status else []

    def paths(self) -> list[PathStatus]:
        """Latency from sources to sinks."""
        return [path for worker in self.workers() for path in worker.paths]

    def data(self) -> dict[str, Any]:
        """In JSON types; rates in 1/s, load as a share of one processor; both null if unknown.

        age_s: seconds since the run, or the worker, answered last; change_awaits: see `RunStatus`.
        """
        status, stages = self.status, self.stages()
        rates = self._rates()
        ages = {age.name: age for _, stage in stages for age in stage.edges}
        unknown = {stage.stage for worker, stage in stages if is_stale(worker)}
        known = [name for name in self.sources if name not in unknown]
        return {
            "type": "run",
            "age_s": round(self.age_s, 1),
            "faults": list(self.faults()),
            "change_awaits": status.change_awaits if status else "",
            "fired": status.fired if status else 0,
            "expected": status.expected if status else None,
            "rate": max((rates.get(f"fired {name}", 0.0) for name in known), default=None),
            "hosts": [asdict(host) for host in status.hosts] if status else [],
            "workers": [_worker(worker) for worker in self.workers()],
            "stages": [_stage(worker, stage, rates) for worker, stage in stages],
            "edges": [_edge(edge, count, rates, ages, unknown) for edge, count in self.edges()],
            "paths": [{**asdict(path), "old": path.sink in unknown} for path in self.paths()],
            "news": list(status.news[-_NEWS:]) if status else [],
            "clocks": [_clock(host, clock) for host, clock in status.clocks.items()] if status else [],
        }

    def _growing(self, status: RunStatus, now: float) -> Mapping[str, _Count]:
        """All counters by name. now: when the status was taken; those of stages are older."""
        found = {edge.name: _Count(float(count.sent), now) for edge, count in status.edges(self.plan)}
        for worker in status.workers:
            reported = now - (worker.stages_age_s or 0.0)
            for stage in worker.stages:
                found[f"fired {stage.stage}"] = _Count(float(stage.fired), reported)
                found[f"busy {stage.stage}"] = _Count(stage.busy_ms, reported)
        return found

    def _rates(self) -> Mapping[str, float]:
        """Growth of each counter, 1/s."""
        if len(self._past) < 2:
            return {}
        (_, old), (_, new) = self._past[0], self._past[-1]
        return {name: round(count.rate_since(old.get(name, count)), 3) for name, count in new.items()}


class _Count(NamedTuple):
    """A counter at one moment. at: on the clock of the monitor, s."""

    value: float
    at: float

    def rate_since(self, before: _Count) -> float:
        """Growth, 1/s; 0 for a counter without a new report, or that began again."""
        seconds = self.at - before.at
        return max(0.0, self.value - before.value) / seconds if seconds > 0.0 else 0.0


def _clock(host: str, clock: ClockStatus) -> dict[str, Any]:
    return {"host": host, **asdict(clock), "warning": clock.warning}


def _state(worker: WorkerStatus, stage: StageStatus) -> StageState:
    """State of a stage: its own report while its worker answers, else the phase of the worker."""
    if worker.phase in ("absent", "over"):
        return worker.phase
    if is_old(worker):
        return "old"
    return stage.state if worker.phase == "running" else "starting"


def _worker(worker: WorkerStatus) -> dict[str, Any]:
    phase = "old" if is_old(worker) else worker.phase
    return {
        "worker": worker.name,
        "host": worker.host,
        "phase": phase,
        "age_s": _rounded(worker.age_s),
        "restarts": worker.restarts,
    }


def _stage(worker: WorkerStatus, stage: StageStatus, rates: Mapping[str, float]) -> dict[str, Any]:
    known = not is_stale(worker)
    return {
        **asdict(stage),
        "worker": worker.name,
        "host": worker.host,
        "age_s": None if known else _rounded(worker.age_s),
        "error": stage.error[:_ERROR],
        "edges": [age.name for age in stage.edges],
        "rate": rates.get(f"fired {stage.stage}", 0.0) if known else None,
        "load": rates.get(f"busy {stage.stage}", 0.0) / 1000.0 if known else None,
    }


def _edge(
    edge: PlannedEdge,
    count: EdgeCount,
    rates: Mapping[str, float],
    ages: Mapping[str, EdgeAge],
    unknown: Container[str],
) -> dict[str, Any]:
    """unknown: stages whose workers are silent; the sender of an edge counts its messages."""
    age = ages.get(edge.name, EdgeAge(edge.name, None, None))
    return {
        "from": f"{edge.from_stage}.{edge.from_port}",
        "to": f"{edge.to_stage}.{edge.to_port}",
        "kind": edge.shown_kind,
        "rate": None if edge.from_stage in unknown else rates.get(edge.name, 0.0),
        "p50_ms": age.p50_ms,
        "p95_ms": age.p95_ms,
        "error": age.error[:_ERROR],
        "old": edge.from_stage in unknown or edge.to_stage in unknown,
        **{name: getattr(count, name) for name in (*COUNTS, *SOURCE_LOSSES)},
    }


def _rounded(age_s: float | None) -> float | None:
    return None if age_s is None else round(age_s, 1)
