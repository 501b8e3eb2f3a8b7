"""A plan as people see it: the instances of a stage in one worker are one box, their edges one line."""

from __future__ import annotations

from dataclasses import dataclass

from followspot.graph.cycles import components, successors, topological
from followspot.graph.plan import EdgeKind, Plan


@dataclass(frozen=True)
class Box:
    """All instances of a stage in one worker; members: that they serve; column: steps from a source."""

    worker: str
    group: str
    uses: str
    members: tuple[str, ...]
    column: int


@dataclass(frozen=True)
class Line:
    """All edges of one kind and codec between the same ports of two boxes; back: against the flow."""

    start: Box
    port: str
    end: Box
    input: str
    kind: EdgeKind
    way: str
    delay: int
    count: int
    back: bool


@dataclass(frozen=True)
class Outline:
    """Boxes in the order of the plan, and the lines between them."""

    boxes: tuple[Box, ...]
    lines: tuple[Line, ...]


def outline(plan: Plan) -> Outline:
    """Fold a plan."""
    columns = _columns(plan)
    boxes: dict[tuple[str, str], Box] = {}
    for stage in plan.stages:
        old = boxes.get((stage.worker, stage.group))
        members = (*(old.members if old else ()), *((stage.member.name,) if stage.member else ()))
        boxes[stage.worker, stage.group] = Box(
            stage.worker, stage.group, stage.uses, members, columns[stage.group]
        )
    box_of = {stage.name: boxes[stage.worker, stage.group] for stage in plan.stages}
    counts: dict[tuple[Box, str, Box, str, EdgeKind, str, int], int] = {}
    for edge in plan.edges:
        key = (
            box_of[edge.from_stage],
            edge.from_port,
            box_of[edge.to_stage],
            edge.to_port,
            edge.kind,
            edge.way,
            edge.delay,
        )
        counts[key] = counts.get(key, 0) + 1
    lines = [Line(*key, count, back=key[0].column >= key[2].column) for key, count in counts.items()]
    return Outline(tuple(boxes.values()), tuple(lines))


def _columns(plan: Plan) -> dict[str, int]:
    """Longest way of each stage from a source, edges that lead back aside."""
    group = {stage.name: stage.group for stage in plan.stages}
    rank = {stage.name: number for number, stage in enumerate(plan.stages)}
    forward = [
        (group[edge.from_stage], group[edge.to_stage])
        for edge in plan.edges
        if rank[edge.from_stage] < rank[edge.to_stage]
    ]
    graph = successors(dict.fromkeys(group.values()), forward)
    component = components(graph)
    graph = {name: [end for end in ends if component[end] != component[name]] for name, ends in graph.items()}
    columns = dict.fromkeys(graph, 0)
    for name in topological(graph):
        for end in graph[name]:
            columns[end] = max(columns[end], columns[name] + 1)
    return columns
