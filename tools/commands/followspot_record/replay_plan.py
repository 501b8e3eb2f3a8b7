"""A plan in which recorded ports take the place of the stages that made them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from followspot.errors import FollowspotError
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, nearest_kind
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot_recording.contract import type_name
from followspot_recording.recording import Recording
from followspot_recording.replays import REPLAYS

_PREFIX = "recording."
NAMES = {type_name(kind): _PREFIX + name for name, kind in REPLAYS.items()}
"""The stage that replays a message type, by the type's full name."""
_ANY = f"{_PREFIX}port"
"""The stage that replays any other type, with the port that sent it in brackets."""


@dataclass(frozen=True)
class Clip:
    """The part of a recording to play. start, stop: s after its beginning; speed: 0 as fast as possible."""

    path: Path
    start: float = 0.0
    stop: float | None = None
    speed: float = 0.0
    loop: bool = False


def replay_stages(recording: Recording, plan: Plan, names: Iterable[str]) -> dict[str, str]:
    """The stage that replays each of these recorded ports of a plan, STAGE.PORT."""
    uses = {stage.name: stage.uses for stage in plan.stages}
    found = {}
    for name in names:
        stage, _, port = name.rpartition(".")
        known = NAMES.get(recording.ports[name].schema)
        again = uses[stage] if uses[stage].startswith(_ANY) else ""  # a replay was recorded
        found[name] = known or again or f"{_ANY}[{uses[stage]}.{port}]"
    return found


def replay_plan(plan: Plan, chosen: Mapping[str, str], clip: Clip) -> Plan:
    """The plan with replays of these ports, without stages that nothing needs then.

    chosen: the stage that replays each port, STAGE.PORT. Raises FollowspotError if no stage is left.
    """
    sources = dict(_sources(plan, chosen, clip))
    replayed = {source.name for source in sources.values()}
    edges = [_redirected(edge, sources) for edge in plan.edges]
    needed = _needed(plan, replayed, edges)
    computed = [stage for stage in plan.stages if stage.name in needed - replayed]
    if not computed:
        raise FollowspotError("nothing is left to compute: every stage that has readers is played")
    stages = [*(source for source in sources.values() if source.name in needed), *computed]
    workers = {stage.worker for stage in stages}
    return replace(
        plan,
        stages=tuple(stages),
        edges=tuple(edge for edge in edges if edge.to_stage in needed - replayed),
        workers=tuple(worker for worker in plan.workers if worker.name in workers),
    )


def on_this_host(plan: Plan) -> Plan:
    """The plan on this host alone: what ran on others runs in the same workers here, without budgets."""
    near = replace(plan, workers=tuple(replace(worker, host="") for worker in plan.workers))
    ends = ((edge, near.placed(edge.from_stage), near.placed(edge.to_stage)) for edge in plan.edges)
    edges = tuple(replace(edge, kind=nearest_kind(start, end), codec="raw") for edge, start, end in ends)
    return replace(near, edges=edges, budgets=())


def in_one_worker(plan: Plan) -> Plan:
    """The plan in one worker on this host."""
    name = plan.workers[0].name
    return on_this_host(
        replace(plan, stages=tuple(replace(s, worker=name) for s in plan.stages), workers=plan.workers[:1])
    )


def _sources(plan: Plan, chosen: Mapping[str, str], clip: Clip) -> Iterator[tuple[str, PlannedStage]]:
    """Each port with the source that replays it; of a stage with one output it has the stage's name."""
    for stage in plan.stages:
        outputs = ports(load_stage(stage.uses)).outputs
        for output in outputs:
            port = f"{stage.name}.{output.name}"
            if port in chosen:
                name = stage.name if len(outputs) == 1 else port
                yield port, _source(stage, name, chosen[port], port, clip)


def _source(stage: PlannedStage, name: str, uses: str, port: str, clip: Clip) -> PlannedStage:
    given: dict[str, Any] = {
        "path": str(clip.path.absolute()),
        "port": port,
        "start_time": clip.start,
        "stop_time": clip.stop,
        "speed": clip.speed,
        "loop": clip.loop,
    }
    params = load_stage(uses).Params(**given).model_dump(mode="json")
    return PlannedStage(name, stage.group, uses, params, stage.member, stage.worker, live=False)


def _redirected(edge: PlannedEdge, sources: Mapping[str, PlannedStage]) -> PlannedEdge:
    """The edge from the source that replays its port, if there is one. sources: by port."""
    source = sources.get(f"{edge.from_stage}.{edge.from_port}")
    return edge if source is None else replace(edge, from_stage=source.name, from_port="out")


def _needed(plan: Plan, sources: set[str], edges: list[PlannedEdge]) -> set[str]:
    """Stages that end the graph and are computed, and what leads to them; sources: names of the played."""
    rank = {stage.name: number for number, stage in enumerate(plan.stages)}
    feeding = {e.from_stage for e in plan.edges if rank[e.from_stage] < rank[e.to_stage]}
    waiting = [s.name for s in plan.stages if s.name not in feeding and s.name not in sources]
    needed = set(waiting)
    while waiting:
        name = waiting.pop()
        before = {e.from_stage for e in edges if e.to_stage == name and name not in sources} - needed
        needed |= before
        waiting += before
    return needed
