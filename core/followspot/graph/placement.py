"""Placements: which worker runs which instance, and on which host."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from followspot.document import Node, child, read
from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.form import Form, is_name, kind_of
from followspot.graph.expand import Expanded
from followspot.graph.names import enclosing
from followspot.graph.plan import PlannedWorker
from followspot.room import Member

MAIN = "main"
"""The worker of all stages that the placement assigns to no other."""
_BY = ("camera", "stage")


@dataclass(frozen=True)
class Placed:
    """Where everything runs: the worker of each instance, and all workers that run something."""

    worker_of: Mapping[str, str]
    workers: tuple[PlannedWorker, ...]
    notes: tuple[str, ...] = ()


def place(expanded: Expanded, placement: str | None, mistakes: list[Mistake]) -> Placed:
    """Place a graph: in one worker, by "camera", by "stage", or as a placement file says; notes mistakes."""
    if placement is None:
        return _together(expanded)
    if placement in _BY:
        return _by(placement, expanded)
    root = _read(placement, mistakes)
    if root is None:
        return _together(expanded)
    if not expanded.complete:
        return _together(expanded)  # its names cannot be judged before the room is mended
    form = Form(root, "a placement", ("placement", "by", "workers"), mistakes)
    form.title("placement")
    by = form.text("by", choices=_BY)
    workers = form.mapping("workers")
    if by is not None and workers:
        mistakes.append(Mistake(form.entries["by"].key, "a placement is either by or workers", "remove one"))
    if by is None and not workers:
        mistakes.append(
            Mistake(root.key, "the placement places nothing", "add by: camera, or workers: {...}")
        )
    return _by(by, expanded) if by is not None else _listed(workers, expanded, mistakes)


def _read(placement: str, mistakes: list[Mistake]) -> Node | None:
    option = Place("--placement", 1, 1, max(1, len(placement)), placement or " ")
    try:
        return read(placement, at=option, remedy="or write camera, or stage")
    except InputError as error:
        mistakes += error.mistakes
        return None


def _together(expanded: Expanded) -> Placed:
    apart = [carrier.name for carrier in expanded.room.carriers if carrier.host]
    note = f"everything runs on this host, though the room has devices on others: {', '.join(apart)}"
    return _placed(dict.fromkeys(expanded.instances, MAIN), {}, (note,) if apart else ())


def _by(by: str, expanded: Expanded) -> Placed:
    """One worker for each camera and sensor, on its host, or for each stage of the file."""
    if by == "stage":
        names = {name: i.declared.name.replace("/", "-") for name, i in expanded.instances.items()}
        return _placed(names, {})
    hosts = {carrier.name: carrier.host for carrier in expanded.room.carriers}
    return _placed({name: _carrier(i.member) or MAIN for name, i in expanded.instances.items()}, hosts)


def _carrier(member: Member | None) -> str:
    """The camera or sensor that an instance serves, "" if it serves neither."""
    return member.name if member is not None and member.set in ("cameras", "sensors") else ""


def _listed(workers: Mapping[str, Node], expanded: Expanded, mistakes: list[Mistake]) -> Placed:
    """As listed; an instance's own name counts first, then its stage, its sub-graphs from the innermost on,
    and its camera or sensor.
    """
    hosts: dict[str, str] = {}
    stages: dict[str, str] = {}
    devices: dict[str, str] = {}
    names = {name: enclosing(i.declared.name) for name, i in expanded.instances.items()}
    known_stages = dict.fromkeys(text for name, outer in names.items() for text in (*outer, name))
    for name, node in workers.items():
        if not is_name(name):
            mistakes.append(
                Mistake(node.key, f'"{name}" cannot be the name of a worker', "letters, digits, _ and -")
            )
        form = Form(node, f'worker "{name}"', ("host", "stages", "cameras", "sensors"), mistakes)
        hosts[name] = form.host()
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
    return _placed(worker_of, hosts)


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


def _placed(worker_of: Mapping[str, str], hosts: Mapping[str, str], notes: tuple[str, ...] = ()) -> Placed:
    """The workers in the order of their first instance."""
    names = dict.fromkeys(worker_of.values())
    return Placed(worker_of, tuple(PlannedWorker(name, hosts.get(name, "")) for name in names), notes)
