"""Placements: which worker runs which instance, and on which host."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.graph.auto_placement.costs import MEASURE, read_costs
from followspot.graph.auto_placement.measured import (
    MeasuredGraph,
    auto,
    check_measured,
    cores_here,
    unreachable_budgets,
)
from followspot.graph.auto_placement.search import AIMS
from followspot.graph.budget import Budget, read_budgets
from followspot.graph.expand import ExpandedGraph
from followspot.graph.names import enclosing
from followspot.graph.plan import PlannedWorker
from followspot.graph.scheduling import KEYS, Scheduling, read_scheduling
from followspot.room import Member
from followspot.valid_values.names import is_name
from followspot.yaml.form import Form, kind_of
from followspot.yaml.node import Node, child
from followspot.yaml.reader import read

MAIN = "main"
"""The worker of all stages that the placement assigns to no other."""
_BY = ("camera", "stage")
_AUTO = re.compile(r"auto(-(?P<aim>throughput|latency))?(:(?P<report>.+))?")


@dataclass(frozen=True)
class Placement:
    """A placement: the worker of each instance, and all workers that run something."""

    worker_of: Mapping[str, str]
    workers: tuple[PlannedWorker, ...]
    notes: tuple[str, ...] = ()
    budgets: tuple[Budget, ...] = ()
    warnings: tuple[Mistake, ...] = ()


def place(expanded: ExpandedGraph, placement: str | None, mistakes: list[Mistake]) -> Placement:
    """Place a graph: in one worker, by "camera", by "stage", by "auto:REPORT.json", or as a placement file
    says; notes mistakes.
    """
    if placement is None:
        return _together(expanded)
    if placement in _BY:
        return _by(placement, expanded)
    if found := _AUTO.fullmatch(placement):
        measured = _measured(expanded, found["report"], _option(placement), mistakes)
        return _together(expanded) if measured is None else _auto(measured, found["aim"])
    root = _read(placement, mistakes)
    if root is None or not expanded.complete:  # names cannot be judged before the room is mended
        return _together(expanded)
    return _as_written(root, placement, expanded, mistakes)


def _as_written(root: Node, file: str, expanded: ExpandedGraph, mistakes: list[Mistake]) -> Placement:
    """Place a graph as the document of a placement file says; notes mistakes."""
    form = Form(root, "a placement", ("placement", "by", "workers", "budget", "costs", "aim"), mistakes)
    form.title("placement")
    by = form.text("by", choices=(*_BY, "auto"))
    workers = form.mapping("workers")
    if by is not None and workers:
        mistakes.append(Mistake(form.entries["by"].key, "a placement is either by or workers", "remove one"))
    budgets = _budgets(form, expanded, mistakes)
    if by is None and not workers and not budgets:
        mistakes.append(
            Mistake(root.key, "the placement places nothing", "add by: camera, or workers: {...}")
        )
    aim, measured = form.text("aim", choices=AIMS), None
    if by == "auto" or "costs" in form.entries:
        where, report = form.entries.get("costs", form.entries.get("by", root)).place, form.text("costs")
        path = None if report is None else str(Path(file).parent / report)
        measured = _measured(expanded, path, where, mistakes)
    if by == "auto":
        placed = _together(expanded) if measured is None else _auto(measured, aim)
    else:
        placed = _by(by, expanded) if by is not None else _listed(workers, expanded, mistakes)
    if measured is None:
        return replace(placed, budgets=budgets)
    places = {budget: form.mapping("budget")[budget.written].key for budget in budgets}
    warnings = tuple(unreachable_budgets(measured, placed.worker_of, places))
    return replace(placed, budgets=budgets, warnings=warnings)


def _auto(measured: MeasuredGraph, aim: str | None) -> Placement:
    worker_of, hosts, notes = auto(measured, "latency" if aim == "latency" else "throughput")
    return _placed(worker_of, hosts, notes)


def _measured(
    expanded: ExpandedGraph, report: str | None, where: Place, mistakes: list[Mistake]
) -> MeasuredGraph | None:
    """The graph with its measured work; notes mistakes. where: the place that asks for it."""
    if report is None:
        text = "auto needs the measured work of the stages"
        mistakes.append(Mistake(where, text, f"{MEASURE}, then --placement auto:report.json"))
        return None
    try:
        measured = MeasuredGraph(expanded, read_costs(Path(report)), cores_here(), where)
    except InputError as error:
        mistakes += [replace(mistake, place=where) for mistake in error.mistakes]
        return None
    found = list(check_measured(measured)) if expanded.complete else []
    mistakes += found
    return None if found or not expanded.complete else measured


def _budgets(form: Form, expanded: ExpandedGraph, mistakes: list[Mistake]) -> tuple[Budget, ...]:
    stages = dict.fromkeys(instance.declared.name for instance in expanded.instances.values())
    forward = (wire for wire in expanded.wires if not wire.feed.delay)
    wires = {(wire.source.declared.name, wire.target.declared.name) for wire in forward}
    return read_budgets(form.mapping("budget"), stages, wires, mistakes)


def _read(placement: str, mistakes: list[Mistake]) -> Node | None:
    try:
        return read(placement, at=_option(placement), remedy="or write camera, stage, or auto:REPORT.json")
    except InputError as error:
        mistakes += error.mistakes
        return None


def _option(placement: str) -> Place:
    return Place("--placement", 1, 1, max(1, len(placement)), placement or " ")


def _together(expanded: ExpandedGraph) -> Placement:
    apart = [carrier.name for carrier in expanded.room.carriers if carrier.host]
    note = f"everything runs on this host, though the room has devices on others: {', '.join(apart)}"
    return _placed(dict.fromkeys(expanded.instances, MAIN), {}, (note,) if apart else ())


def _by(by: str, expanded: ExpandedGraph) -> Placement:
    """One worker for each camera and sensor, on its host, or for each stage of the file."""
    if by == "stage":
        names = {name: i.declared.name.replace("/", "-") for name, i in expanded.instances.items()}
        return _placed(names, {})
    hosts = {carrier.name: carrier.host for carrier in expanded.room.carriers}
    return _placed({name: _carrier(i.member) or MAIN for name, i in expanded.instances.items()}, hosts)


def _carrier(member: Member | None) -> str:
    """The camera or sensor that an instance serves, "" if it serves neither."""
    return member.name if member is not None and member.set in ("cameras", "sensors") else ""


def _listed(workers: Mapping[str, Node], expanded: ExpandedGraph, mistakes: list[Mistake]) -> Placement:
    """Place each instance in the worker that lists it.

    The instance's own name counts first, then its stage, its sub-graphs from the innermost on, and its camera
    or sensor.
    """
    hosts: dict[str, str] = {}
    scheduled: dict[str, Scheduling] = {}
    stages: dict[str, str] = {}
    devices: dict[str, str] = {}
    names = {name: enclosing(i.declared.name) for name, i in expanded.instances.items()}
    known_stages = dict.fromkeys(text for name, outer in names.items() for text in (*outer, name))
    for name, node in workers.items():
        if not is_name(name):
            mistakes.append(
                Mistake(
                    node.key, f'"{name}" cannot be the name of a worker', "1 to 100 letters, digits, _ and -"
                )
            )
        form = Form(node, f'worker "{name}"', ("host", "stages", "cameras", "sensors", *KEYS), mistakes)
        hosts[name] = form.host()
        scheduled[name] = read_scheduling(form)
        _claim(name, child(node, "stages"), "stage", known_stages, stages, mistakes)
        _claim(name, child(node, "cameras"), "camera", expanded.room.cameras, devices, mistakes)
        _claim(name, child(node, "sensors"), "sensor", expanded.room.sensors, devices, mistakes)
    worker_of = {}
    for name, instance in expanded.instances.items():
        claims = (stages.get(text) for text in (name, *reversed(names[name])))
        by_name = next((worker for worker in claims if worker is not None), None)
        worker_of[name] = by_name or devices.get(_carrier(instance.member)) or MAIN
    running = set(worker_of.values())
    mistakes += [
        Mistake(node.key, f'worker "{name}" runs nothing', "give it stages, cameras or sensors, or remove it")
        for name, node in workers.items()
        if name not in running
    ]
    return _placed(worker_of, hosts, scheduled=scheduled)


def _claim(
    worker: str,
    names: Node | None,
    noun: str,
    known: Collection[str],
    taken: dict[str, str],
    mistakes: list[Mistake],
) -> None:
    """Give the listed stages, cameras or sensors to a worker."""
    if names is None or names.value is None:
        return
    if not isinstance(names.value, tuple):
        mistakes.append(
            Mistake(names.place, f"{noun}s is a list of names, not {kind_of(names)}", f"{noun}s: [NAME, ...]")
        )
        return
    for node in names.value:
        name = str(node.value)
        if name not in known:
            mistakes.append(
                Mistake(node.place, f'there is no {noun} "{name}"', did_you_mean(name, known, f"{noun}s"))
            )
        elif name in taken:
            mistakes.append(
                Mistake(node.place, f'{noun} "{name}" is placed twice', f'worker "{taken[name]}" has it')
            )
        else:
            taken[name] = worker


def _placed(
    worker_of: Mapping[str, str],
    hosts: Mapping[str, str],
    notes: tuple[str, ...] = (),
    scheduled: Mapping[str, Scheduling] = MappingProxyType({}),
) -> Placement:
    """The workers in the order of their first instance."""
    workers = tuple(
        PlannedWorker(name, hosts.get(name, ""), scheduled.get(name, Scheduling()))
        for name in dict.fromkeys(worker_of.values())
    )
    return Placement(worker_of, workers, notes)
