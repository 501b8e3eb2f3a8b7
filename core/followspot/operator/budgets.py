"""Budgets of paths while a run goes on: which are missed, and which stage or wait takes the most time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from followspot.control.host import WorkerStatus
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.graph.budget import Budget, reachable
from followspot.graph.plan import Plan, PlannedEdge


@dataclass(frozen=True)
class Part:
    """A part of the time on a path. ms: mean work of a stage, or the wait before it; text: says which."""

    ms: float
    text: str


def missed_budgets(plan: Plan, workers: Iterable[WorkerStatus]) -> Iterator[str]:
    """A line for each path that misses its budget now: more than 5 % of its newest messages are late."""
    workers = tuple(workers)
    stages = {stage.stage: stage for worker in workers for stage in worker.stages}
    for path in (path for worker in workers if worker.phase == "running" for path in worker.paths):
        budget = _budget(plan, path)
        if budget is not None and path.recent_ms is not None and path.recent_ms > budget.limit_ms:
            line = f"{path.origin} -> {path.sink} misses its budget of {budget.limit_ms:g} ms: 95 % of the"
            yield f"{line} newest messages take up to {path.recent_ms:.1f} ms{_fault(plan, path, stages)}"


def overruns(plan: Plan, workers: Iterable[WorkerStatus]) -> Iterator[str]:
    """A line for each path of a run that has ended on which messages were late."""
    workers = tuple(workers)
    stages = {stage.stage: stage for worker in workers for stage in worker.stages}
    for path in (path for worker in workers for path in worker.paths):
        budget = _budget(plan, path)
        if budget is not None and path.late:
            line = f"{path.origin} -> {path.sink} missed its budget of {budget.limit_ms:g} ms"
            yield f"{line} with {path.late} of {path.count} messages{_fault(plan, path, stages)}"


def largest_part(plan: Plan, origin: str, end: str, stages: Mapping[str, StageStatus]) -> Part | None:
    """The part that takes the most time from a stage of the graph file to an instance; None if unknown.

    Follow the path back from its end, at each stage along the input whose messages are oldest when they are
    taken. Age beyond that of the sender's inputs and the sender's work is time in which messages waited.
    """
    into = _edges_between(plan, origin, end)
    ages = {edge.name: edge.p95_ms for stage in stages.values() for edge in stage.edges}
    found: list[Part] = []
    name, seen = end, set[str]()
    while name in stages and name not in seen and into.get(name):
        seen.add(name)
        work = _work(stages[name])
        found.append(Part(work, f"{name} works {work:.1f} ms"))
        edge = max(into[name], key=lambda edge: ages.get(edge.name) or 0.0)
        sender = edge.from_stage
        before = max((ages.get(e.name) or 0.0 for e in into.get(sender, ())), default=0.0)
        sent = before + _work(stages[sender]) if into.get(sender) and sender in stages else 0.0
        wait = max(0.0, (ages.get(edge.name) or 0.0) - sent)
        found.append(
            Part(wait, f"messages wait {wait:.1f} ms before {name}, which works {work:.1f} ms on each")
        )
        name = sender
    return max(found, key=lambda part: part.ms, default=None)


def _fault(plan: Plan, path: PathStatus, stages: Mapping[str, StageStatus]) -> str:
    part = largest_part(plan, path.origin, path.sink, stages)
    return f"; {part.text}" if part is not None and part.ms > 0.0 else ""


def _budget(plan: Plan, path: PathStatus) -> Budget | None:
    groups = {stage.name: stage.group for stage in plan.stages}
    end = groups.get(path.sink)
    return next((b for b in plan.budgets if (b.origin, b.end) == (path.origin, end)), None)


def _edges_between(plan: Plan, origin: str, end: str) -> Mapping[str, list[PlannedEdge]]:
    """The edges on the ways from a stage of the graph file to an instance, by the stage they lead to."""
    forward = [(edge.from_stage, edge.to_stage) for edge in plan.edges if not edge.delay]
    sources = [stage.name for stage in plan.stages if stage.group == origin]
    after = set[str]().union(*(reachable(name, forward) for name in sources))
    before = reachable(end, ((b, a) for a, b in forward))
    into: dict[str, list[PlannedEdge]] = {}
    for edge in plan.edges:
        if not edge.delay and edge.from_stage in after & before and edge.to_stage in before:
            into.setdefault(edge.to_stage, []).append(edge)
    return into


def _work(stage: StageStatus) -> float:
    """Mean work of a firing, ms."""
    return stage.busy_ms / stage.fired if stage.fired else 0.0
