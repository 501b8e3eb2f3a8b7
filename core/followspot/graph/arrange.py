"""Last step: stages in order, edges with their kinds, workers; a plan that can be shipped and run."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from followspot.graph.check import CheckedGraph
from followspot.graph.checks.rates import nominal_rate
from followspot.graph.connections import CheckedEdge
from followspot.graph.cycles import cyclic, successors, topological
from followspot.graph.depths import INPUT_DEPTHS, live_depth
from followspot.graph.instances import CheckedStage
from followspot.graph.parameter_origin import kept_parameters, origins
from followspot.graph.placement import Placement
from followspot.graph.plan import EdgeKind, Plan, PlannedEdge, PlannedStage, nearest_kind
from followspot.graph.seen_cameras import seen_cameras
from followspot.room import Room

EdgeChoice = Literal["auto", "reference", "ring", "zenoh"]
_NEAREST_FIRST: tuple[EdgeKind, ...] = ("reference", "ring", "zenoh")


def plan(
    checked: CheckedGraph,
    placed: Placement,
    edges: EdgeChoice = "auto",
    *,
    seed: int | None = None,
    plugin_files: tuple[str, ...] = (),
) -> Plan:
    """The plan of a graph without mistakes; its notes name every request that could not be met."""
    stages = {stage.instance.name: stage for stage in checked.stages}
    planned = [planned_edge(edge, placed, edges) for edge in checked.edges]
    return Plan(
        graph=checked.name,
        room=checked.room,
        stages=tuple(planned_stage(stages[name], placed, checked.room) for name in _order(checked)),
        edges=tuple(planned),
        workers=placed.workers,
        seed=checked.seed if seed is None else seed,
        plugin_files=plugin_files,
        notes=(*checked.notes, *placed.notes, *_notes(planned, edges)),
        offered=checked.offered,
        warnings=(*checked.warnings, *placed.warnings),
        room_document=checked.room_document,
        subgraphs=checked.subgraphs,
        origins=origins(checked),
        budgets=placed.budgets,
    )


def on_host(plan: Plan, host: str) -> Plan:
    """The plan with the workers that were to run on the operator's host on another one."""
    workers = tuple(replace(worker, host=worker.host or host) for worker in plan.workers)
    moved = replace(plan, workers=workers)
    edges = []
    for edge in plan.edges:
        before, after = (
            {found.host_of_stage(end) for end in (edge.from_stage, edge.to_stage)} for found in (plan, moved)
        )
        joined = len(after) == 1 < len(before)
        edges.append(replace(edge, kind="ring", codec="raw") if joined else edge)
    return replace(moved, edges=tuple(edges))


def _order(checked: CheckedGraph) -> list[str]:
    """Topological, edges that lead back in a cycle aside; else as in the file and the room."""
    names = [stage.instance.name for stage in checked.stages]
    ends = [(edge.wire.source.name, edge.wire.target.name) for edge in checked.edges]
    edges = list(zip(ends, checked.edges, strict=True))
    circular = cyclic(ends)
    undelayed = cyclic([pair for pair, edge in edges if not edge.wire.feed.delay])
    back = [pair in (undelayed if edge.sampled else circular) and edge.held for pair, edge in edges]
    forward = [pair for pair, leads_back in zip(ends, back, strict=True) if not leads_back]
    return topological(successors(names, forward))


def planned_stage(checked: CheckedStage, placed: Placement, room: Room) -> PlannedStage:
    """The instance in its worker."""
    instance = checked.instance
    declared = instance.declared
    return PlannedStage(
        name=instance.name,
        group=declared.name,
        uses=instance.uses,
        params=checked.params,
        member=instance.member,
        worker=placed.worker_of[instance.name],
        live=checked.stage.live,
        on_error=declared.on_error,
        tolerance=checked.tolerance,
        deadline=declared.deadline,
        depth=declared.depth or live_depth(nominal_rate(checked, room) if checked.stage.live else None),
        concurrency=declared.concurrency,
        kept=kept_parameters(instance),
        sees=seen_cameras(checked, room),
    )


def planned_edge(edge: CheckedEdge, placed: Placement, choice: EdgeChoice = "auto") -> PlannedEdge:
    """The edge between two workers, or within one."""
    wire = edge.wire
    kind = _kind(wire.source.name, wire.target.name, placed, choice)
    return PlannedEdge(
        from_stage=wire.source.name,
        from_port=edge.output,
        to_stage=wire.target.name,
        to_port=wire.port,
        kind=kind,
        delay=wire.feed.delay,
        depth=_depth(edge),
        codec=wire.feed.codec if kind == "zenoh" else "raw",
        tolerance=wire.feed.tolerance,
        policy=wire.feed.policy,
    )


def _depth(edge: CheckedEdge) -> int:
    """The written depth, else one for the kind of input."""
    written = edge.wire.feed.depth
    return written if "depth" in edge.wire.feed.places else INPUT_DEPTHS.get(edge.kind, written)


def _kind(source: str, target: str, placed: Placement, choice: EdgeChoice) -> EdgeKind:
    """The requested kind of edge if it is possible, else the nearest."""
    workers = {worker.name: worker for worker in placed.workers}
    nearest = nearest_kind(workers[placed.worker_of[source]], workers[placed.worker_of[target]])
    return nearest if choice == "auto" else max(nearest, choice, key=_NEAREST_FIRST.index)


def _notes(edges: list[PlannedEdge], choice: EdgeChoice) -> list[str]:
    """Notes on edges that could not get the requested kind."""
    if choice == "auto":
        return []
    reason = "they join two workers" if choice == "reference" else "they join two hosts"
    others = [edge for edge in edges if edge.kind != choice]
    kinds = sorted({edge.kind for edge in others})
    return [f"{len(others)} edges are {' or '.join(kinds)} and not {choice}: {reason}"] if others else []
