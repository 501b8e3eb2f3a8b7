"""The plans of a run's hosts, which differ if an operator died before all had the new one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from followspot.graph.change.difference import differing_stages, differing_workers
from followspot.graph.plan import Plan, PlannedStage

_REMEDY = "the next move, swap or set of the run brings all hosts to one plan first"
_NO_REMEDY = "stop the run, and start it anew"


@dataclass(frozen=True)
class PlanConflict:
    """Two plans of one run. other: the plan of some hosts, which is not that of the run.

    text: a line that says what differs, and the remedy; curable: whether all hosts can be brought to the
    run's plan: some host has the parameters of each of its stages.
    """

    other: Plan
    text: str
    curable: bool

    def workers(self, plan: Plan) -> set[str]:
        """The workers of either plan that differ from it. plan: of the run."""
        return differing_workers(_outline(self.other), _outline(plan))


def merged_plan(plans: Mapping[str, Plan]) -> Plan:
    """The plan of a run; each stage is as its own host knows it, because other hosts lack its parameters.

    plans: by host. If they differ, that which the hosts can be brought to; see `plan_conflict`.
    """
    own = _own(plans)
    plan = max(plans.values(), key=lambda plan: (_is_complete(plan, own), plan.rows))
    stages = (replace(own.get(s.name, s), worker=s.worker) for s in plan.stages)
    return replace(plan, stages=tuple(stages))


def plan_conflict(plans: Mapping[str, Plan], plan: Plan) -> PlanConflict | None:
    """The conflict between the plans of the hosts and the plan of the run; None if they agree."""
    outline = _outline(plan)
    others = {name: other for name, other in plans.items() if differing_workers(_outline(other), outline)}
    if not others:
        return None
    other = next(iter(others.values()))
    stages = sorted(differing_stages(_outline(other), outline))
    same = ", ".join(name for name in plans if name not in others)
    sides = (
        f"by that of {same}, {_places(plan, stages)}",
        f"by that of {', '.join(others)}, {_places(other, stages)}",
    )
    curable = plan.live and _is_complete(plan, _own(plans))
    text = (
        f"hosts have different plans: {'; '.join(sides)}. A change is under way, or was interrupted: "
        f"{_REMEDY if curable else _NO_REMEDY}"
    )
    return PlanConflict(other, text, curable)


def _own(plans: Mapping[str, Plan]) -> dict[str, PlannedStage]:
    """The stages that a host runs by its own plan, by name."""
    return {
        stage.name: stage
        for host, plan in plans.items()
        for stage in plan.stages
        if plan.host_of(stage.worker) == host
    }


def _is_complete(plan: Plan, own: Mapping[str, PlannedStage]) -> bool:
    return all(stage.name in own for stage in plan.stages)


def _outline(plan: Plan) -> Plan:
    """The plan without details of stages: a host gets those of its own stages only."""
    stages = tuple(replace(stage, uses="", params={}, kept=()) for stage in plan.stages)
    return replace(plan, stages=stages)


def _places(plan: Plan, stages: Sequence[str]) -> str:
    """The workers of these stages by the plan, as text; without stages, that edges differ."""
    worker = {stage.name: f"in worker {stage.worker}" for stage in plan.stages}
    places = (f"{name} is {worker.get(name, 'absent')}" for name in stages)
    return " and ".join(places) or f"there are {len(plan.edges)} edges"
