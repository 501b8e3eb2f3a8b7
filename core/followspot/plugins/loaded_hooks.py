"""Finds the hook modules of all installed packages, and loads each separately."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar

import pluggy

from followspot.operating_system.standard_output import importing
from followspot.plugins.hooks import (
    PROJECT,
    Command,
    Hooks,
    Keeper,
    PlanOptions,
    RecordingReader,
    Scorer,
)

GROUP = "followspot.hooks.v1"
_ON_RUNS = ("attach", "swap", "set", "move")
RESERVED = ("run", "check", "graph", "plugins", "agent", "router", *_ON_RUNS, "certs", "completion")
"""Commands of followspot itself."""
_OFFERED: Mapping[str, type] = {
    "followspot_commands": Command,
    "followspot_plan_options": PlanOptions,
    "followspot_recording_readers": RecordingReader,
    "followspot_scorers": Scorer,
    "followspot_keepers": Keeper,
}
"""The type of the offers of each hook."""

T = TypeVar("T")


@dataclass(frozen=True)
class HookModule:
    """A module of hooks; problem: why it could not be loaded, empty if it was."""

    name: str
    value: str
    distribution: str
    problem: str = ""


@dataclass(frozen=True)
class LoadedHooks:
    """All hook modules with their commands, options, readers, scorers and keepers."""

    modules: tuple[HookModule, ...]
    commands: tuple[Command, ...]
    plan_options: tuple[PlanOptions, ...]
    readers: tuple[RecordingReader, ...]
    scorers: tuple[Scorer, ...]
    keepers: tuple[Keeper, ...]


@cache
def load_hooks() -> LoadedHooks:
    """Load each hook module separately: a broken one is named and left out."""
    modules: list[HookModule] = []
    offers: list[object] = []
    taken = dict.fromkeys(RESERVED, "followspot")
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name):
        found, problem = _load(entry)
        for offer in found:
            if isinstance(offer, Command):
                if other := taken.get(offer.title) or taken.get(offer.parent or ""):
                    problem = f'command "{offer.title}" is already offered by {other}'
                    continue
                taken[offer.title] = entry.name
            offers.append(offer)
        distribution = entry.dist.name if entry.dist is not None else "?"
        modules.append(HookModule(entry.name, entry.value, distribution, problem))
    return LoadedHooks(
        tuple(modules),
        commands=_of_type(Command, offers),
        plan_options=_of_type(PlanOptions, offers),
        readers=_of_type(RecordingReader, offers),
        scorers=_of_type(Scorer, offers),
        keepers=_of_type(Keeper, offers),
    )


def load_commands() -> Sequence[Command]:
    """The commands of all hook modules that are well."""
    return load_hooks().commands


def load_scorers() -> Sequence[Scorer]:
    """The scorers of all hook modules that are well."""
    return load_hooks().scorers


def load_plan_options() -> Sequence[PlanOptions]:
    """The plan options of all hook modules that are well."""
    return load_hooks().plan_options


def _load(entry: EntryPoint) -> tuple[Sequence[object], str]:
    """Import and register one hook module: its offers, and the problem with it, "" if there is none."""
    manager = pluggy.PluginManager(PROJECT)
    manager.add_hookspecs(Hooks)
    try:
        with importing():
            module = entry.load()
        manager.register(module, name=entry.name)
        manager.check_pending()
        problem = _ignored_by_pluggy(module)
        offered = {hook: _ask(manager, hook) for hook in _OFFERED}
    except (Exception, SystemExit) as error:
        return (), " ".join(f"{type(error).__name__}: {error}".split())
    for hook, kind in _OFFERED.items():
        if not all(isinstance(offer, kind) for offer in offered[hook]):
            return (), f"{hook} returns something that is no {kind.__name__}"
    return [offer for offers in offered.values() for offer in offers], problem


def _ask(manager: pluggy.PluginManager, hook: str) -> list[Any]:
    """The offers of the registered module by one hook."""
    return [offer for offers in getattr(manager.hook, hook)() for offer in offers]


def _ignored_by_pluggy(module: object) -> str:
    """The mistake in a module that pluggy ignores: a hook without the mark, no hook at all; "" for none."""
    functions = {
        name: hasattr(value, f"{PROJECT}_impl")
        for name, value in vars(module).items()
        if name.startswith(f"{PROJECT}_") and callable(value)
    }
    for name, marked in functions.items():
        if not marked:
            return f"{name} is not marked with @hookimpl"
    known = ", ".join(name for name in vars(Hooks) if name.startswith(f"{PROJECT}_"))
    return "" if functions else f"the module implements no hook; known: {known}"


def _of_type(kind: type[T], offers: Sequence[object]) -> tuple[T, ...]:
    return tuple(offer for offer in offers if isinstance(offer, kind))
