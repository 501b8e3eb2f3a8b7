"""A plan as people see it: the instances of a stage in one worker are one box, their edges one line.

Folded, all stages of a sub-graph in one worker are one box.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from followspot.graph.cycles import components, successors, topological
from followspot.graph.names import subgraphs
from followspot.graph.plan import EdgeKind, Plan, PlannedStage


@dataclass(frozen=True)
class Box:
    """All instances of a stage in one worker, or of a sub-graph; members: that they serve.

    name: of the stage or the sub-graph; stages: how many of the graph file are in it; column: steps from a
    source.
    """

    worker: str
    name: str
    uses: str
    members: tuple[str, ...]
    column: int
    stages: int = 1


@dataclass(frozen=True)
class Line:
    """All edges of one kind and codec between the same ports of two boxes; back: against the flow."""

    start: Box
    port: str
    end: Box
    input: str
    kind: EdgeKind
    shown_kind: str
    delay: int
    count: int
    back: bool

    @property
    def sender(self) -> str:
        """The port that the line comes from: STAGE.PORT."""
        return _joined(self.start, self.port)

    @property
    def reader(self) -> str:
        """The port that the line leads to: STAGE.PORT."""
        return _joined(self.end, self.input)


@dataclass(frozen=True)
class Outline:
    """Boxes in the order of the plan, and the lines between them."""

    boxes: tuple[Box, ...]
    lines: tuple[Line, ...]


def outline(plan: Plan, *, fold: bool = True) -> Outline:
    """The boxes and lines of a plan; fold: whether each outermost sub-graph is one box in each worker."""
    name = {stage.name: _name(stage, fold) for stage in plan.stages}
    columns = _columns(plan, name)
    members: dict[tuple[str, str], list[PlannedStage]] = {}
    for stage in plan.stages:
        members.setdefault((stage.worker, name[stage.name]), []).append(stage)
    boxes = {key: _box(*key, found, columns[key[1]]) for key, found in members.items()}
    box_of = {stage.name: boxes[stage.worker, name[stage.name]] for stage in plan.stages}
    inside = {stage.name: stage.group.removeprefix(name[stage.name]).lstrip("/") for stage in plan.stages}
    counts: dict[tuple[Box, str, Box, str, EdgeKind, str, int], int] = {}
    for edge in plan.edges:
        start, end = box_of[edge.from_stage], box_of[edge.to_stage]
        if start is end and inside[edge.from_stage]:
            continue  # within a folded sub-graph
        output, port = (
            _port(inside[edge.from_stage], edge.from_port),
            _port(inside[edge.to_stage], edge.to_port),
        )
        key = (start, output, end, port, edge.kind, edge.shown_kind, edge.delay)
        counts[key] = counts.get(key, 0) + 1
    lines = [Line(*key, count, back=key[0].column >= key[2].column) for key, count in counts.items()]
    return Outline(tuple(boxes.values()), tuple(lines))


def _name(stage: PlannedStage, fold: bool) -> str:
    """The box of a stage."""
    return next(iter(subgraphs(stage.group)), stage.group) if fold else stage.group


def _box(worker: str, name: str, members: list[PlannedStage], column: int) -> Box:
    served = tuple(dict.fromkeys(stage.member.name for stage in members if stage.member))
    box = Box(worker, name, members[0].uses, served, column)
    groups = {stage.group for stage in members}
    if groups == {name}:
        return box
    return replace(box, uses=f"sub-graph, {len(groups)} stage{'s' * (len(groups) > 1)}", stages=len(groups))


def _joined(box: Box, port: str) -> str:
    """The full name of a port of a box; in a folded one the port names its stage."""
    return f"{box.name}/{port}" if "." in port else f"{box.name}.{port}"


def _port(stage: str, port: str) -> str:
    """A port as a line names it: within a folded sub-graph with its stage."""
    return f"{stage}.{port}" if stage else port


def _columns(plan: Plan, name: Mapping[str, str]) -> dict[str, int]:
    """Longest way of each box from a source, edges that lead back aside; name: of the box, by instance."""
    rank = {stage.name: number for number, stage in enumerate(plan.stages)}
    forward = [
        (name[edge.from_stage], name[edge.to_stage])
        for edge in plan.edges
        if rank[edge.from_stage] < rank[edge.to_stage]
    ]
    graph = successors(dict.fromkeys(name.values()), forward)
    component = components(graph)
    graph = {
        start: [end for end in ends if component[end] != component[start]] for start, ends in graph.items()
    }
    columns = dict.fromkeys(graph, 0)
    for start in topological(graph):
        for end in graph[start]:
            columns[end] = max(columns[end], columns[start] + 1)
    return columns
