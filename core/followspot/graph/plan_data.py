"""A plan in JSON types, to send it to the processes that run it; checked on the way in."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

import pydantic

from followspot.errors import FollowspotError
from followspot.graph.budget import Budget
from followspot.graph.plan import MAX_SEED, Plan, PlannedEdge, PlannedStage, PlannedWorker
from followspot.graph.scheduling import Scheduling
from followspot.graph.subgraph_use import SubgraphUse
from followspot.room_document.data import from_data, to_data

VERSION = 2
"""Of the form of the data."""


_USES = pydantic.TypeAdapter(tuple[SubgraphUse, ...])


class PlanDataError(FollowspotError):
    """The data are not a plan of this version."""


class _Data(pydantic.BaseModel):
    """The data of a plan."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=False)

    version: int
    graph: str
    room: dict[str, Any]
    stages: tuple[PlannedStage, ...]
    edges: tuple[PlannedEdge, ...]
    workers: tuple[PlannedWorker, ...]
    seed: Annotated[int, pydantic.Field(ge=0, le=MAX_SEED)]
    plugin_files: tuple[str, ...]
    notes: tuple[str, ...]
    offered: dict[str, tuple[str, ...]] = {}
    subgraphs: tuple[SubgraphUse, ...] = ()
    numbers: tuple[Annotated[int, pydantic.Field(ge=0)], ...] = ()
    former: tuple[tuple[Annotated[int, pydantic.Field(ge=0)], PlannedEdge], ...] = ()
    budgets: tuple[Budget, ...] = ()
    additions: tuple[Annotated[int, pydantic.Field(ge=0)], ...] = ()


def plan_to_data(plan: Plan) -> dict[str, Any]:
    """The plan in JSON types."""
    offered = {name: list(ports) for name, ports in plan.offered.items()}
    return {
        **({"offered": offered} if offered else {}),
        **({"subgraphs": _USES.dump_python(plan.subgraphs, mode="json")} if plan.subgraphs else {}),
        **({"numbers": list(plan.numbers)} if plan.numbers else {}),
        **({"former": [[number, asdict(edge)] for number, edge in plan.former]} if plan.former else {}),
        **({"additions": list(plan.additions)} if plan.additions else {}),
        **(
            {"budgets": [{**asdict(budget), "written": ""} for budget in plan.budgets]}
            if plan.budgets
            else {}
        ),
        "version": VERSION,
        "graph": plan.graph,
        "room": to_data(plan.room),
        "stages": [_stage(stage) for stage in plan.stages],
        "edges": [asdict(edge) for edge in plan.edges],
        "workers": [_worker(worker) for worker in plan.workers],
        "seed": plan.seed,
        "plugin_files": list(plan.plugin_files),
        "notes": list(plan.notes),
    }


def _stage(stage: PlannedStage) -> dict[str, Any]:
    sees = None if stage.sees is None else list(stage.sees)
    return {**asdict(stage), "params": dict(stage.params), "kept": list(stage.kept), "sees": sees}


def _worker(worker: PlannedWorker) -> dict[str, Any]:
    wanted = worker.scheduling
    said = {"scheduling": {**asdict(wanted), "cores": list(wanted.cores)}} if wanted != Scheduling() else {}
    return {"name": worker.name, "host": worker.host, **said}


def plan_from_data(data: Any) -> Plan:
    """The plan from the result of `plan_to_data`. Raises PlanDataError, InputError (from the room)."""
    try:
        found = _Data.model_validate(data)
    except pydantic.ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise PlanDataError(f"this is no plan: {where}: {first['msg']}") from None
    if found.version != VERSION:
        raise PlanDataError(f"the plan has version {found.version}, this followspot reads {VERSION}")
    _check_names(found)
    return Plan(
        graph=found.graph,
        room=from_data(found.room),
        stages=found.stages,
        edges=found.edges,
        workers=found.workers,
        seed=found.seed,
        plugin_files=found.plugin_files,
        notes=found.notes,
        offered=found.offered,
        subgraphs=found.subgraphs,
        numbers=found.numbers,
        former=found.former,
        budgets=found.budgets,
        additions=found.additions,
    )


def _check_names(found: _Data) -> None:
    """Raise PlanDataError if names or numbers of a plan contradict each other."""
    stages = {stage.name for stage in found.stages}
    workers = {worker.name for worker in found.workers}
    if len(stages) < len(found.stages) or len(workers) < len(found.workers):
        raise PlanDataError("this is no plan: a name stands for two stages or workers")
    strangers = {stage.worker for stage in found.stages} - workers
    strangers |= {end for edge in found.edges for end in (edge.from_stage, edge.to_stage)} - stages
    taken = {*found.numbers, *(number for number, _ in found.former)}
    if found.numbers and (
        len(found.numbers) != len(found.edges) or len(taken) < len(found.numbers) + len(found.former)
    ):
        raise PlanDataError("this is no plan: each edge has a number of its own")
    if max(taken, default=-1) >= len(found.edges) + len(found.former):
        raise PlanDataError("this is no plan: the number of an edge is too large")
    if strangers:
        raise PlanDataError(
            f"this is no plan: it speaks of {', '.join(sorted(strangers))} without saying what it is"
        )
