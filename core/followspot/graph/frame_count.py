"""The sources that a number of frames counts, those of sensors that end with them, and the sinks."""

from __future__ import annotations

from followspot.graph.plan import Plan, PlannedStage


def counted_sources(plan: Plan) -> frozenset[str]:
    """The sources that give frames: all that serve no sensor; every source if there is no other."""
    return frozenset(stage.name for stage in _sources(plan) if not _of_sensor(stage)) or sources(plan)


def accompanying_sources(plan: Plan) -> frozenset[str]:
    """The sources of sensors that give readings as long as others give frames; none without others."""
    return sources(plan) - counted_sources(plan)


def sources(plan: Plan) -> frozenset[str]:
    """The stages that no edge leads to."""
    return frozenset(stage.name for stage in _sources(plan))


def sinks(plan: Plan) -> list[PlannedStage]:
    """The stages that no edge leads from."""
    senders = {edge.from_stage for edge in plan.edges}
    return [stage for stage in plan.stages if stage.name not in senders]


def _sources(plan: Plan) -> list[PlannedStage]:
    fed = {edge.to_stage for edge in plan.edges}
    return [stage for stage in plan.stages if stage.name not in fed]


def _of_sensor(stage: PlannedStage) -> bool:
    return stage.member is not None and stage.member.set == "sensors"
