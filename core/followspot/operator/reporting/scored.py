"""Which files of a run can be scored: those in which sinks write messages of a type as a table."""

from __future__ import annotations

from pathlib import Path

from followspot.graph.plan import Plan, PlannedStage
from followspot.messages import Message
from followspot.plugins.registry import PluginError, load_stage
from followspot.ports.signature import ports
from followspot.stage import Stage


def scored_file(plan: Plan, kind: type[Message]) -> Path | None:
    """The table of messages of a type that is scored: of several, that of the sink farthest downstream.

    It is relative to the run's output folder; None if no sink writes one.
    """
    return next(iter(written_tables(plan, kind)), None)


def written_tables(plan: Plan, kind: type[Message]) -> tuple[Path, ...]:
    """The tables of messages of a type, from the sink farthest downstream on.

    Sinks say that they write tables by `Stage.table_path`.
    """
    classes = {stage.name: class_of(stage) for stage in plan.stages}
    found = []
    for stage in reversed(plan.stages):
        sink = classes[stage.name]
        if sink is not None and sink.table_path and _receives(plan, stage.name, kind, classes):
            found.append(Path(stage.params[sink.table_path]))
    return tuple(found)


def _receives(plan: Plan, name: str, kind: type[Message], classes: dict[str, type[Stage] | None]) -> bool:
    """Whether every edge into a stage brings messages of that type."""
    edges = [edge for edge in plan.edges if edge.to_stage == name]
    types = []
    for edge in edges:
        source = classes[edge.from_stage]
        port = ports(source).output(edge.from_port) if source is not None else None
        types.append(port is not None and issubclass(port.type, kind))
    return bool(types) and all(types)


def class_of(stage: PlannedStage) -> type[Stage] | None:
    """The class of a stage; None if this host does not have its plugin."""
    try:
        return load_stage(stage.uses)
    except PluginError:  # it runs on another host
        return None
