"""The outcome of a change or a move: the differences in the run's plan."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from followspot.graph.change.lost_values import lost_values
from followspot.graph.change.move import restarted_workers
from followspot.graph.change.stages import Change
from followspot.graph.change.subgraph_change import BY_A_CHANGE
from followspot.graph.plan import Plan, PlannedStage


@dataclass(frozen=True)
class StageOutcome:
    """A changed stage. before, uses: the old and the new plugin stage, "" for one that comes or goes; params:
    parameters that differ now.

    origins: what gave these their values, of those that the change itself does not give; not_taken: values
    that were set before, for which no stage has a parameter now.
    """

    stage: str
    before: str
    uses: str
    params: dict[str, Any]
    origins: dict[str, str] = field(default_factory=dict)
    not_taken: dict[str, Any] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """One line."""
        lost = [f"{name} = {value}" for name, value in self.not_taken.items()]
        return self._change + (f"; not taken over: {', '.join(lost)}" if lost else "")

    @property
    def _change(self) -> str:
        if not self.uses:
            return f"{self.stage}: left ({self.before})"
        if not self.before:
            return f"{self.stage}: came ({self.uses})"
        swapped = [f"{self.before} -> {self.uses}"] if self.uses != self.before else []
        values = [f"{name} = {value}{self._origin(name)}" for name, value in self.params.items()]
        return f"{self.stage}: " + ", ".join([*swapped, *values])

    def _origin(self, name: str) -> str:
        return f" from {self.origins[name]}" if name in self.origins else ""


@dataclass(frozen=True)
class ChangeOutcome:
    """The outcome of a change."""

    run: str
    graph: str
    stages: tuple[StageOutcome, ...]


@dataclass(frozen=True)
class MoveOutcome:
    """The outcome of a move. stages: moved to `worker` on `host`; restarted: the workers that did."""

    run: str
    graph: str
    stages: tuple[str, ...]
    worker: str = ""
    host: str = ""
    restarted: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """One line."""
        place = f"worker {self.worker}" + (f" on {self.host}" if self.host else "")
        return f"{', '.join(self.stages)}: to {place}; restarted workers: {', '.join(self.restarted)}"

    @staticmethod
    def of(run: str, old: Plan, new: Plan) -> MoveOutcome:
        """The move that leads from the old plan to the new one."""
        gone = [stage for stage in new.stages if stage.worker != old.worker_of(stage.name)]
        if not gone:
            return MoveOutcome(run, old.graph, ())
        worker = gone[0].worker
        names = tuple(stage.name for stage in gone)
        again = tuple(sorted(restarted_workers(old, new) & {found.name for found in new.workers}))
        return MoveOutcome(run, old.graph, names, worker, new.host_of(worker), again)


def outcome_of_change(run: str, plan: Plan, change: Change) -> ChangeOutcome:
    """The outcome of a change to a plan."""
    old = {stage.name: stage for stage in plan.stages}
    new = change.applied(plan)
    there = {stage.name for stage in new.stages}
    lost = lost_values(plan, new)
    found = [
        StageOutcome(s.name, s.uses, "", {}, not_taken=lost.get(s.name, {}))
        for s in plan.stages
        if s.name not in there
    ]
    for stage in new.stages:
        if stage.name not in old:
            found.append(StageOutcome(stage.name, "", stage.uses, {}))
            continue
        if (stage.uses, stage.params) == (old[stage.name].uses, old[stage.name].params):
            continue
        params = _differing(old[stage.name], stage)
        given = new.origins.get(stage.name, {})
        origins = {name: given[name].text for name in params if name in given and given[name] != BY_A_CHANGE}
        before, values = old[stage.name].uses, lost.get(stage.name, {})
        found.append(StageOutcome(stage.name, before, stage.uses, params, origins, values))
    return ChangeOutcome(run, plan.graph, tuple(found))


def with_change(plan: Plan, change: Change) -> Plan:
    """The plan after a change, with the change in its notes."""
    notes = [f"while it ran: {stage.text}" for stage in outcome_of_change("", plan, change).stages]
    return replace(change.applied(plan), notes=(*plan.notes, *notes)[-_MAX_NOTES:])


_MAX_NOTES = 100


def _differing(old: PlannedStage, new: PlannedStage) -> dict[str, Any]:
    return {name: value for name, value in new.params.items() if old.params.get(name) != value}
