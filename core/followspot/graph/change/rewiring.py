"""A plan with another graph file in the place of a sub-graph: stages that come, stay and go, and their edges.

An edge keeps its number as long as it is between the same ports in the same way. The edges that leave the
sub-graph begin at the ports behind the same outputs of the interface.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from followspot.errors import InputError, Mistake, Place
from followspot.graph.arrange import planned_edge, planned_stage
from followspot.graph.change.outgoing_edges import leaving
from followspot.graph.change.subgraph_plan import ComposedFile
from followspot.graph.cycles import cyclic, successors, topological
from followspot.graph.parameters import output_paths
from followspot.graph.placement import Placement
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage
from followspot.graph.sampling import plan_sampled_cycles
from followspot.graph.subgraph_use import SubgraphUse
from followspot.plugins.registry import load_stage
from followspot.ports.firing import FIRINGS
from followspot.ports.signature import ports


def plan_with_file(plan: Plan, use: SubgraphUse, found: ComposedFile, place: Place) -> Plan:
    """The plan with the file in the place of the use. place: of the file's name. Raises InputError."""
    old = {stage.name: stage for stage in plan.stages if use.holds(stage.group)}
    stages = _stages(plan, found, _placed(plan, old, found), old)
    edges = _edges(plan, use, found, stages, place)
    numbers, former = _numbered(plan, edges)
    names = {stage.worker for stage in stages.values()}
    new = replace(
        plan,
        stages=tuple(_ordered(stages, edges, place)),
        edges=tuple(edges),
        workers=tuple(worker for worker in plan.workers if worker.name in names),
        offered=_offered(plan, use, found),
        numbers=numbers,
        former=former,
        additions=(*plan.additions, plan.rows),
    )
    _check(plan, new, place)
    return new


def _placed(plan: Plan, old: Mapping[str, PlannedStage], found: ComposedFile) -> Placement:
    """Places new stages in the worker of old stages of the same member, else of those without a member.

    Old stages stay in their workers.
    """
    beside = {stage.member: stage.worker for stage in old.values()}
    fallback = beside.get(None) or next(reversed(beside.values()))
    workers = {stage.name: stage.worker for stage in plan.stages if stage.name not in old}
    for stage in found.stages:
        name, member = stage.instance.name, stage.instance.member
        workers[name] = old[name].worker if name in old else beside.get(member, fallback)
    return Placement(workers, plan.workers)


def _stages(
    plan: Plan, found: ComposedFile, placed: Placement, old: Mapping[str, PlannedStage]
) -> dict[str, PlannedStage]:
    """All stages of the new plan, those of the file where the first of the old ones was."""
    inside = {}
    for checked in found.stages:
        stage = planned_stage(checked, placed, plan.room)
        was = old.get(stage.name)
        before = was.kept if was is not None else ()
        kept = tuple(dict.fromkeys(name for name in (*before, *stage.kept) if name in stage.params))
        inside[stage.name] = replace(stage, kept=kept)
    stages: dict[str, PlannedStage] = {}
    for stage in plan.stages:
        stages |= inside if stage.name in old else {stage.name: stage}
    return stages


def _edges(
    plan: Plan, use: SubgraphUse, found: ComposedFile, stages: Mapping[str, PlannedStage], place: Place
) -> list[PlannedEdge]:
    """The edges of the new plan; edges that stay are the same objects."""
    placed = Placement({stage.name: stage.worker for stage in stages.values()}, plan.workers)
    before = {edge.name + f" {edge.delay}": edge for edge in plan.edges}
    inside = []
    for checked in found.checked_edges:
        edge = planned_edge(checked, placed)
        was = before.get(edge.name + f" {edge.delay}")
        same = was is not None and replace(edge, kind=was.kind, codec=was.codec) == was
        inside.append(was if was is not None and same else edge)
    return [*_outside(plan, use, found, stages, place), *inside]


def _outside(
    plan: Plan, use: SubgraphUse, found: ComposedFile, stages: Mapping[str, PlannedStage], place: Place
) -> list[PlannedEdge]:
    """The edges to stages outside the file; the firings of a stage are read as long as its results are."""
    outside = [edge for edge in plan.edges if not use.holds(edge.to_stage)]
    before = [edge for edge in outside if edge.from_port != FIRINGS]
    after = [leaving(plan, use, found, e, stages, place) if use.holds(e.from_stage) else e for e in before]
    moved = {
        old.from_stage for old, new in zip(before, after, strict=True) if old.from_stage != new.from_stage
    }
    read = stages.keys() - moved
    return [*after, *(edge for edge in outside if edge.from_port == FIRINGS and edge.from_stage in read)]


def _numbered(
    plan: Plan, edges: list[PlannedEdge]
) -> tuple[tuple[int, ...], tuple[tuple[int, PlannedEdge], ...]]:
    """The number of each edge, and the edges that have left."""
    before = {edge: number for number, edge in plan.numbered()}
    free = iter(range(plan.rows, plan.rows + len(edges)))
    numbers = tuple(before[edge] if edge in before else next(free) for edge in edges)
    gone = ((number, edge) for number, edge in plan.numbered() if number not in set(numbers))
    return numbers, (*plan.former, *gone)


def _ordered(
    stages: Mapping[str, PlannedStage], edges: list[PlannedEdge], place: Place
) -> Iterator[PlannedStage]:
    """The stages in topological order. Raises InputError if they wait for each other."""
    pairs = [(edge.from_stage, edge.to_stage) for edge in edges]
    circular = cyclic(pairs)
    undelayed = cyclic([pair for pair, edge in zip(pairs, edges, strict=True) if not edge.delay])
    forward = []
    for pair, edge in zip(pairs, edges, strict=True):
        port = ports(load_stage(stages[edge.to_stage].uses)).input(edge.to_port)
        sampled = port is not None and port.kind == "latest" and not edge.delay
        if not (pair in (undelayed if sampled else circular) and (sampled or edge.delay)):
            forward.append(pair)
    _check_lagging(stages, circular, place)
    try:
        order = topological(successors(stages, forward))
    except ValueError:
        text = "with this file, stages of the graph would wait for each other"
        raise InputError([Mistake(place, text, "delay one edge of the file")]) from None
    return (stages[name] for name in order)


def _check_lagging(stages: Mapping[str, PlannedStage], circular: set[tuple[str, str]], place: Place) -> None:
    for start, _ in circular:
        if ports(load_stage(stages[start].uses)).gives == "lagged":
            text = f'stage "{start}" lags and would wait for its own output'
            raise InputError([Mistake(place, text, "feed back what does not lag")])


def _offered(plan: Plan, use: SubgraphUse, found: ComposedFile) -> dict[str, tuple[str, ...]]:
    """The outputs of all sub-graphs."""
    around = {
        name: behind
        for name, behind in plan.offered.items()
        if not (name.partition(".")[0] == use.name or use.holds(name.partition(".")[0]))
    }
    own = {port for behind in found.outputs.values() for port in behind}
    for name, behind in around.items():
        if any(use.holds(port.partition(".")[0]) for port in behind):
            others = tuple(port for port in behind if not use.holds(port.partition(".")[0]))
            same = found.outputs.get(f"{use.name}.{name.partition('.')[2]}", ())
            around[name] = (*others, *(port for port in same if port in own))
    return {name: behind for name, behind in {**around, **found.outputs}.items() if behind}


def _check(plan: Plan, new: Plan, place: Place) -> None:
    """Raise InputError if the new stages cannot begin while the graph runs."""
    before = {stage.name: stage for stage in plan.stages}
    fed = {edge.to_stage for edge in new.edges}
    writers = {path: stage.name for stage in plan.stages for path in _paths(stage)}
    mistakes: list[Mistake] = []
    for stage in new.stages:
        was = before.get(stage.name)
        if stage.name not in fed and not stage.live and (was is None or was.uses != stage.uses):
            text = f'source "{stage.name}" would begin its stream anew'
            mistakes.append(Mistake(place, text, "only live sources can come while a graph runs"))
        if was is None or (was.uses, was.params) != (stage.uses, stage.params):
            mistakes += _shared_files(stage, writers, place)
    if not mistakes and new.live != plan.live:
        mistakes.append(Mistake(place, "a live graph stays live, and a replay a replay"))
    if not mistakes and not new.live:
        mistakes += [replace(mistake, place=place) for mistake in plan_sampled_cycles(new)]
    if mistakes:
        raise InputError(mistakes)


def _shared_files(stage: PlannedStage, writers: Mapping[str, str], place: Place) -> Iterator[Mistake]:
    """A mistake for each file of the stage that a stage of the old plan is writing. writers: by path."""
    for path in _paths(stage):
        if path in writers:
            text = f'stage "{stage.name}" would write {path}, which "{writers[path]}" is writing'
            yield Mistake(place, text, "name another file")


def _paths(stage: PlannedStage) -> list[str]:
    return list(output_paths(load_stage(stage.uses).Params, stage.params))
