"""A graph with the measured work of its stages, for `--placement auto` and budgets."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from followspot.errors import Mistake, Place
from followspot.graph.auto_placement.costs import MEASURE, Costs
from followspot.graph.auto_placement.pipeline_model import PipelineModel
from followspot.graph.auto_placement.search import Aim, PlacementUnit, choose, explained
from followspot.graph.budget import Budget
from followspot.graph.expand import ExpandedGraph
from followspot.graph.instances import Instance

_MOST_UNITS = 60
"""Units of a graph that are placed one by one; a larger one is placed by cameras."""


@dataclass(frozen=True)
class MeasuredGraph:
    """A graph with the work of its stages as a report has measured it.

    cores: number of cores of this host; place: of the text that names the report, for mistakes.
    """

    expanded: ExpandedGraph
    costs: Costs
    cores: int
    place: Place

    def missing(self) -> tuple[str, ...]:
        """The instances for which the report has no figures."""
        return tuple(name for name in self.expanded.instances if name not in self.costs.work)

    def model(self, remote: frozenset[str] = frozenset()) -> PipelineModel:
        """The model of the graph. remote: instances on other hosts."""
        work = {name: self.costs.work[name] for name in self.expanded.instances}
        wires = [(w.source.name, w.target.name, w.feed.delay) for w in self.expanded.wires]
        return PipelineModel(work, tuple(dict.fromkeys(wires)), self.cores, remote)


def cores_here() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def check_measured(measured: MeasuredGraph) -> Iterator[Mistake]:
    """A mistake if the report is of another graph."""
    missing = measured.missing()
    if missing:
        more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        text = f'{measured.costs.name} has no figures of stage "{missing[0]}"{more}'
        yield Mistake(measured.place, text, f"measure this graph in this room: {MEASURE}")


def auto(measured: MeasuredGraph, aim: Aim) -> tuple[Mapping[str, str], Mapping[str, str], tuple[str, ...]]:
    """The worker of each instance, the host of each worker, and lines that explain the choice."""
    hosts = {c.name: c.host for c in measured.expanded.room.carriers if c.host}
    units = _units(tuple(measured.expanded.instances.values()), hosts)
    remote = frozenset(name for unit in units if unit.fixed for name in unit.instances)
    choice = choose(measured.model(remote), units, aim)
    source = f"{measured.costs.name} ({measured.costs.frames} frame sets)"
    notes = explained(choice, aim, measured.cores, source)
    return choice.worker_of, {name: name for name in hosts.values()}, notes


def unreachable_budgets(
    measured: MeasuredGraph, worker_of: Mapping[str, str], budgets: Mapping[Budget, Place]
) -> Iterator[Mistake]:
    """A warning for each budget that the measured work alone exceeds, with the stage that works longest."""
    model = measured.model()
    for budget, place in budgets.items():
        ends = [i.name for i in measured.expanded.instances.values() if i.declared.name == budget.end]
        takes = model.latency_to(ends, worker_of)
        if takes > budget.limit_ms:
            slowest = max(_between(model, budget, ends, measured.expanded), key=model.work.__getitem__)
            text = f"{budget.name} cannot be kept: by {measured.costs.name} it takes {takes:.1f} ms when"
            text += f" nothing waits; {slowest} works longest, {model.work[slowest]:.1f} ms"
            yield Mistake(place, text, "give it another stage, other parameters or more time", warning=True)


def _between(model: PipelineModel, budget: Budget, ends: Sequence[str], expanded: ExpandedGraph) -> list[str]:
    """The ends of a budget and all instances upstream of them, its sources left out."""
    inputs = model.inputs()
    found, waiting = dict.fromkeys(ends), list(ends)
    while waiting:
        new = [start for start, delay in inputs[waiting.pop()] if not delay and start not in found]
        found |= dict.fromkeys(new)
        waiting += new
    return [name for name in found if expanded.instances[name].declared.name != budget.origin]


def _units(instances: Sequence[Instance], hosts: Mapping[str, str]) -> tuple[PlacementUnit, ...]:
    """The instances that stay together."""
    groups: dict[str, list[Instance]] = {}
    many = len(instances) > _MOST_UNITS
    for instance in instances:
        carrier = _carrier(instance)
        name = carrier or ("main" if many else instance.name)
        groups.setdefault(name, []).append(instance)
    return tuple(
        PlacementUnit(
            name, tuple(i.name for i in found), bool(_carrier(found[0])), hosts.get(_carrier(found[0]), "")
        )
        for name, found in groups.items()
    )


def _carrier(instance: Instance) -> str:
    """The camera or sensor that an instance serves, "" if it serves neither."""
    member = instance.member
    return member.name if member is not None and member.set in ("cameras", "sensors") else ""
