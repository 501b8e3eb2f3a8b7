"""Stages of a running plan that move: the new kinds of edges, and the workers that start anew."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from followspot.errors import InputError, Mistake, did_you_mean
from followspot.graph.names import enclosing
from followspot.graph.plan import EdgeKind, Plan, PlannedEdge, PlannedStage, PlannedWorker, nearest_kind

_ALONE = "; another host joins only a run that was begun with agents, --listen or --router"


def plan_after_move(plan: Plan, names: Sequence[str], place: str, others: Collection[str] = ()) -> Plan:
    """The plan with these stages in another worker. Raises InputError.

    names: stages of the graph file, instances of them, or sub-graphs; place: a worker, or a host, whose first
    worker takes them; others: reachable hosts without a worker, which get one of their own name.
    """
    known = {name for stage in plan.stages for name in _names(stage)}
    mistakes = [
        Mistake(None, f'the graph has no stage "{name}"', did_you_mean(name, known, "stages"))
        for name in names
        if name not in known
    ]
    worker = next((w for w in plan.workers if place in (w.name, w.host)), None)
    if worker is None and place in others:
        worker = PlannedWorker(place, place)
    if worker is None:
        places = {name for w in plan.workers for name in (w.name, w.host) if name} | set(others)
        remedy = f"{did_you_mean(place, places, 'workers and hosts')}{'' if others else _ALONE}"
        mistakes.append(Mistake(None, f'there is no worker or host "{place}" in reach of the run', remedy))
    if not plan.live:
        remedy = "stop it and run it with another --placement"
        mistakes.append(Mistake(None, "stages move in live runs only: a replay would lose messages", remedy))
    if mistakes or worker is None:
        raise InputError(mistakes)
    going = {stage.name for stage in plan.stages if set(_names(stage)) & set(names)}
    return _arranged(plan, going, worker)


def restarted_workers(old: Plan, new: Plan) -> set[str]:
    """Workers, of either plan, to be started again: their stages or the kinds of their edges differ."""
    plans = (old, new)
    pairs = ({plan.worker_of(stage.name) for plan in plans} for stage in old.stages)
    found = {worker for pair in pairs if len(pair) > 1 for worker in pair}
    for before, after in zip(old.edges, new.edges, strict=True):
        ends = (before.from_stage, before.to_stage)
        keys = {tuple(map(plan.host_of_stage, ends)) for plan in plans}
        if before.kind != after.kind or (after.kind == "zenoh" and len(keys) > 1):
            found |= {plan.worker_of(end) for plan in plans for end in ends}
    return found


def _names(stage: PlannedStage) -> tuple[str, ...]:
    """The instance, its stage and its sub-graphs."""
    return (stage.name, *enclosing(stage.group))


def _arranged(plan: Plan, going: Collection[str], worker: PlannedWorker) -> Plan:
    """The plan with these instances in this worker; workers without stages are gone."""
    stages = tuple(replace(s, worker=worker.name) if s.name in going else s for s in plan.stages)
    kept = {stage.worker for stage in stages}
    workers = tuple(w for w in dict.fromkeys((*plan.workers, worker)) if w.name in kept)
    there = {w.name: w for w in workers}
    place = {stage.name: there[stage.worker] for stage in stages}
    edges = tuple(
        _edge(edge, nearest_kind(place[edge.from_stage], place[edge.to_stage]))
        if {edge.from_stage, edge.to_stage} & set(going)
        else edge
        for edge in plan.edges
    )
    return replace(plan, stages=stages, workers=workers, edges=edges)


def _edge(edge: PlannedEdge, kind: EdgeKind) -> PlannedEdge:
    return replace(edge, kind=kind, codec=edge.codec if kind == "zenoh" else "raw")


def host_workers(plan: Plan, host: str) -> list[PlannedWorker]:
    """The workers of a host, "" for the operator's own."""
    return [worker for worker in plan.workers if worker.host == host]
