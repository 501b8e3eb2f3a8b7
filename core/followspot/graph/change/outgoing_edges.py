"""Edges that leave a sub-graph after another file has taken its place: they begin behind the same output."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from followspot.errors import InputError, Mistake, Place
from followspot.graph.change.subgraph_plan import ComposedFile
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, nearest_kind
from followspot.graph.subgraph_use import SubgraphUse
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.ports.specs import OutputSpec, accepts


def leaving(
    plan: Plan,
    use: SubgraphUse,
    found: ComposedFile,
    edge: PlannedEdge,
    stages: Mapping[str, PlannedStage],
    place: Place,
) -> PlannedEdge:
    """The edge from the port that the file has behind the same output, for the same member of the fan-out.

    stages: of the new plan. Raises InputError if there is none that its reader takes, or several.
    """
    start = next(stage for stage in plan.stages if stage.name == edge.from_stage)
    port = f"{edge.from_stage}.{edge.from_port}"
    names = [n for n, behind in plan.offered.items() if n.partition(".")[0] == use.name and port in behind]
    behind = [new for n in names for new in found.outputs.get(n, ())]
    if not names and edge.from_stage in stages:  # the graph reads a stage of the file itself
        behind = [port]
    candidates = dict.fromkeys(_fitting(behind, edge, start, stages))
    if port in candidates:
        candidates = {port: None}
    elif len(alike := [new for new in candidates if new.rpartition(".")[2] == edge.from_port]) == 1:
        candidates = dict.fromkeys(alike)
    if len(candidates) != 1:
        raise InputError([_refusal(use, names, found, edge, list(candidates or behind), stages, place)])
    stage, _, output = next(iter(candidates)).rpartition(".")
    workers = {worker.name: worker for worker in plan.workers}
    kind = nearest_kind(workers[stages[stage].worker], workers[stages[edge.to_stage].worker])
    if stages[stage].worker == start.worker:
        kind = edge.kind
    codec = edge.codec if kind == "zenoh" else "raw"
    return replace(edge, from_stage=stage, from_port=output, kind=kind, codec=codec)


def _fitting(
    behind: Sequence[str], edge: PlannedEdge, start: PlannedStage, stages: Mapping[str, PlannedStage]
) -> Iterator[str]:
    """The ports behind an output whose type the reader takes, for the member of the old sender."""
    read = ports(load_stage(stages[edge.to_stage].uses)).input(edge.to_port)
    before = _output(start, edge.from_port)
    for port in behind:
        name, _, output = port.rpartition(".")
        stage = stages[name]
        given = _output(stage, output)
        if read is None or before is None or given is None or stage.member != start.member:
            continue
        if accepts(read.type, given.type) and (given.type is before.type or not read.uniform):
            yield port


def _output(stage: PlannedStage, port: str) -> OutputSpec | None:
    return ports(load_stage(stage.uses)).output(port)


def _refusal(
    use: SubgraphUse,
    names: list[str],
    found: ComposedFile,
    edge: PlannedEdge,
    given: list[str],
    stages: Mapping[str, PlannedStage],
    place: Place,
) -> Mistake:
    """given: the ports that the reader could take, or all behind the output if it can take none."""
    if not names:
        text = f'"{edge.to_stage}" reads {edge.from_stage}.{edge.from_port}, which the file lacks'
        remedy = "let it read an output of the interface; a recording has ports that --record-ports names"
        return Mistake(place, text, remedy)
    output = names[0].partition(".")[2]
    if not any(name in found.outputs for name in names):
        return Mistake(place, f'sub-graph "{use.name}" has no output "{output}" in the file', "offer it")
    gives = ", ".join(f"{port} ({_type(port, stages)})" for port in given)
    reader = f"{edge.to_stage}.{edge.to_port}"
    read = ports(load_stage(stages[edge.to_stage].uses)).input(edge.to_port)
    wanted = read.type.__name__ if read is not None else "nothing"
    text = f'output "{output}" of the file gives {gives}, and "{reader}" takes one {wanted}'
    return Mistake(place, text, f"before, it read {edge.from_stage}.{edge.from_port}")


def _type(port: str, stages: Mapping[str, PlannedStage]) -> str:
    """Name of the message type of a port."""
    name, _, output = port.rpartition(".")
    found = _output(stages[name], output)
    return "nothing" if found is None else found.type.__name__
