"""Checks that a stage has the inputs and settings that the graph gives it."""

from __future__ import annotations

from collections.abc import Mapping

from followspot.errors import Mistake, did_you_mean
from followspot.graph.declaration import InputDeclaration
from followspot.graph.instances import Instance
from followspot.ports.signature import ports
from followspot.ports.specs import Ports
from followspot.room import SETS
from followspot.stage import Stage


def check_inputs(
    instance: Instance, stage: type[Stage], left_out: Mapping[str, Mistake], mistakes: list[Mistake]
) -> None:
    """Note settings and inputs that the stage lacks, and each required input that nothing feeds."""
    declared, found = instance.declared, ports(stage)
    _check_settings(instance, stage, found, mistakes)
    _check_served(instance, stage, mistakes)
    for entry in declared.inputs:
        _check_input(instance, entry, found, left_out, mistakes)
    named = {entry.port for entry in declared.inputs}
    missing = [port for port in found.inputs if port.required and port.name not in named]
    if len(missing) <= len(named - {port.name for port in found.inputs}):
        return  # the names that the stage lacks are those of the missing ones, misspelt
    for port in missing:
        text = f'stage "{declared.name}" ({instance.uses}) needs the input "{port.name}"'
        advice = f"add in: {{{port.name}: STAGE}}, a stage that gives {port.type.__name__}"
        mistakes.append(Mistake(declared.place, text, advice))


def _check_settings(instance: Instance, stage: type[Stage], found: Ports, mistakes: list[Mistake]) -> None:
    """Note a depth or a concurrency that the stage does not have."""
    declared = instance.declared
    if declared.depth is not None and not stage.live:
        text = f'stage "{declared.name}" ({instance.uses}) is no live source and has no depth of its own'
        mistakes.append(Mistake(declared.places["depth"], text, "write the depth where an input is fed"))
    if "concurrency" in declared.places and found.gives != "later":
        text = f'stage "{declared.name}" ({instance.uses}) answers at once and has no concurrency'
        use = "remove it, or use a stage that returns Deferred[...]"
        mistakes.append(Mistake(declared.places["concurrency"], text, use))


def _check_served(instance: Instance, stage: type[Stage], mistakes: list[Mistake]) -> None:
    """Note a fan-out that is missing, or over others than the members that the stage serves."""
    declared, served = instance.declared, stage.serves()
    if served and declared.each is None:
        text = f'{instance.uses} serves one {SETS[served]}, and stage "{declared.name}" has no each'
        mistakes.append(Mistake(declared.place, text, f"add each: {served}"))
    elif served and instance.member is not None and instance.member.set != served:
        over = declared.each.text if declared.each is not None else ""
        text = f'{instance.uses} serves one {SETS[served]}, but stage "{declared.name}" fans out over {over}'
        mistakes.append(Mistake(declared.places["each"], text, f"write each: {served}"))


def _check_input(
    instance: Instance,
    entry: InputDeclaration,
    found: Ports,
    left_out: Mapping[str, Mistake],
    mistakes: list[Mistake],
) -> None:
    """Note an input that the stage lacks, and a required one whose senders are all left out."""
    name, port = instance.declared.name, found.input(entry.port)
    if found.source:
        text = f'stage "{name}" ({instance.uses}) is a source and has no inputs'
        mistakes.append(Mistake(entry.place, text, "remove it"))
    elif port is None:
        remedy = did_you_mean(entry.port, [port.name for port in found.inputs], "inputs")
        mistakes.append(Mistake(entry.place, f'stage "{name}" has no input "{entry.port}"', remedy))
    elif port.required and entry.feeds and all(feed.stage in left_out for feed in entry.feeds):
        text = f'input "{entry.port}" of stage "{name}" needs what is left out'
        reasons = [left_out[feed.stage] for feed in entry.feeds]
        why = "; ".join(reason.text for reason in reasons)
        place = entry.place if reasons[0].place is None else entry.place.within(reasons[0].place)
        mistakes.append(Mistake(place, text, f'{why}; write optional: true for "{name}", too'))
