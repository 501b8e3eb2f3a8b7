"""The outcome of a change or a move: what differs in the run's plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from followspot.graph.change import with_stages
from followspot.graph.move import anew
from followspot.graph.plan import Plan, PlannedStage


@dataclass(frozen=True)
class ChangedStage:
    """A changed stage. before, uses: the old and the new plugin stage; params: parameters that differ now."""

    stage: str
    before: str
    uses: str
    params: dict[str, Any]

    @property
    def text(self) -> str:
        """One line."""
        swapped = [f"{self.before} -> {self.uses}"] if self.uses != self.before else []
        return f"{self.stage}: " + ", ".join([*swapped, *(f"{k} = {v}" for k, v in self.params.items())])


@dataclass(frozen=True)
class Changed:
    """The outcome of a change."""

    run: str
    graph: str
    stages: tuple[ChangedStage, ...]


@dataclass(frozen=True)
class Moved:
    """The outcome of a move. stages: moved to `worker` on `host`; anew: workers that restarted for it."""

    run: str
    graph: str
    stages: tuple[str, ...]
    worker: str = ""
    host: str = ""
    anew: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """One line."""
        place = f"worker {self.worker}" + (f" on {self.host}" if self.host else "")
        return f"{', '.join(self.stages)}: to {place}; restarted workers: {', '.join(self.anew)}"

    @staticmethod
    def of(run: str, old: Plan, new: Plan) -> Moved:
        """The move that leads from the old plan to the new one."""
        gone = [stage for stage in new.stages if stage.worker != old.worker_of(stage.name)]
        if not gone:
            return Moved(run, old.graph, ())
        worker = gone[0].worker
        names = tuple(stage.name for stage in gone)
        again = tuple(sorted(anew(old, new) & {found.name for found in new.workers}))
        return Moved(run, old.graph, names, worker, new.host_of(worker), again)


def changed(run: str, plan: Plan, stages: Sequence[PlannedStage]) -> Changed:
    """The change that these stages make to a plan."""
    old = {stage.name: stage for stage in plan.stages}
    found = [ChangedStage(s.name, old[s.name].uses, s.uses, _differing(old[s.name], s)) for s in stages]
    return Changed(run, plan.graph, tuple(found))


def with_change(plan: Plan, stages: Sequence[PlannedStage]) -> Plan:
    """The plan after a change, with the change in its notes."""
    notes = [f"while it ran: {stage.text}" for stage in changed("", plan, stages).stages]
    return replace(with_stages(plan, stages), notes=(*plan.notes, *notes)[-_MAX_NOTES:])


_MAX_NOTES = 100


def _differing(old: PlannedStage, new: PlannedStage) -> dict[str, Any]:
    return {name: value for name, value in new.params.items() if old.params.get(name) != value}
