"""The hooks that a package can implement, and the loading of the packages that do.

A package names a module in the entry-point group `followspot.hooks.v1`; the module's functions marked with
`hookimpl` are the hooks. `followspot --help` imports these modules, so they import nothing heavy at the top.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from inspect import cleandoc
from pathlib import Path
from typing import Any

import pluggy

GROUP = "followspot.hooks.v1"
PROJECT = "followspot"
_ON_RUNS = ("attach", "swap", "set", "move")
RESERVED = ("run", "check", "graph", "plugins", "agent", "router", *_ON_RUNS, "certs", "completion")
"""Commands of followspot itself."""

hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@dataclass(frozen=True)
class Command:
    """One command of the command line.

    configure: adds the arguments; run: returns the exit code, its docstring is the help; parent: name of a
    group, for `followspot PARENT NAME`.
    """

    name: str
    configure: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]
    parent: str | None = None

    @property
    def help(self) -> str:
        """Its first line is the entry in the list of commands; the whole text is the command's own --help."""
        return cleandoc(self.run.__doc__ or "")

    @property
    def title(self) -> str:
        """The name as the user types it."""
        return f"{self.parent} {self.name}" if self.parent else self.name


def _nobody(_args: argparse.Namespace) -> AbstractContextManager[None]:
    """Default of `watch`: no observer."""
    return nullcontext()


@dataclass(frozen=True)
class PlanOptions:
    """Options of every command that plans a graph, their effect on the plan, and an observer of its run.

    configure: adds the options; change: returns the plan (`followspot.graph.plan.Plan`) that
    the options ask for, the same one if they ask for nothing; raises InputError; watch: a context that is
    open while a graph runs in this process, for an observer (`followspot.control.unix_socket`).
    """

    configure: Callable[[argparse.ArgumentParser], None]
    change: Callable[[Any, argparse.Namespace], Any]
    watch: Callable[[argparse.Namespace], AbstractContextManager[None]] = _nobody


@dataclass(frozen=True)
class RecordingReader:
    """Opens recordings for scripts (`followspot.open_recording`). suffix: of the files, for example `.mcap`.

    open: from a path to a `followspot.Recording`; raises FollowspotError.
    """

    suffix: str
    open: Callable[[Path], Any]


@dataclass(frozen=True)
class Scorer:
    """Scores runs against one kind of ground truth. name: of its scores in summaries, for example "targets".

    load: gives the `followspot.scoring.Scoring`; it is called when there is something to score.
    """

    name: str
    load: Callable[[], Any]


@dataclass(frozen=True)
class Keeper:
    """Keeps the last seconds of runs of scripts (`keep=` of `followspot.run`).

    start: from the plan, a `followspot.Keep` and the name of the run to a context that is open while the run
    goes on; it yields a function that takes the errors of a run that failed. check: raises FollowspotError
    if a plan cannot be kept so.
    """

    check: Callable[[Any, Any], None]
    start: Callable[[Any, Any, str], AbstractContextManager[Callable[[Sequence[str]], None]]]


class Hooks:
    """Specifications of the hooks."""

    @hookspec
    def followspot_commands(self) -> Sequence[Command]:  # type: ignore[empty-body]
        """Commands to add to the command line."""

    @hookspec
    def followspot_plan_options(self) -> Sequence[PlanOptions]:  # type: ignore[empty-body]
        """Options to add to run, check and graph, which change the plan."""

    @hookspec
    def followspot_recording_readers(self) -> Sequence[RecordingReader]:  # type: ignore[empty-body]
        """Formats of recordings that scripts can open."""

    @hookspec
    def followspot_scorers(self) -> Sequence[Scorer]:  # type: ignore[empty-body]
        """Scores of runs against ground truth."""

    @hookspec
    def followspot_keepers(self) -> Sequence[Keeper]:  # type: ignore[empty-body]
        """Flight recorders of runs of scripts."""


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
    readers: tuple[RecordingReader, ...] = ()
    scorers: tuple[Scorer, ...] = ()
    keepers: tuple[Keeper, ...] = ()


@dataclass(frozen=True)
class _Offer:
    """Commands, options, readers, scorers and keepers of one module; problem: why some are missing."""

    problem: str = ""
    commands: list[Command] = field(default_factory=list)
    plan_options: list[PlanOptions] = field(default_factory=list)
    readers: list[RecordingReader] = field(default_factory=list)
    scorers: list[Scorer] = field(default_factory=list)
    keepers: list[Keeper] = field(default_factory=list)


@cache
def load_hooks() -> LoadedHooks:
    """Load each hook module separately: a broken one is named and left out."""
    modules: list[HookModule] = []
    commands: list[Command] = []
    plan_options: list[PlanOptions] = []
    readers: list[RecordingReader] = []
    scorers: list[Scorer] = []
    keepers: list[Keeper] = []
    taken = dict.fromkeys(RESERVED, "followspot")
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name):
        offer = _load(entry)
        problem = offer.problem
        plan_options += offer.plan_options
        readers += offer.readers
        scorers += offer.scorers
        keepers += offer.keepers
        for command in offer.commands:
            other = taken.get(command.title) or taken.get(command.parent or "")
            if other:
                problem = f'command "{command.title}" is already offered by {other}'
            else:
                taken[command.title] = entry.name
                commands.append(command)
        distribution = entry.dist.name if entry.dist is not None else "?"
        modules.append(HookModule(entry.name, entry.value, distribution, problem))
    return LoadedHooks(
        tuple(modules),
        tuple(commands),
        tuple(plan_options),
        tuple(readers),
        tuple(scorers),
        tuple(keepers),
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


def _load(entry: EntryPoint) -> _Offer:
    """Import, register and ask one module."""
    manager = pluggy.PluginManager(PROJECT)
    manager.add_hookspecs(Hooks)
    try:
        module = entry.load()
        manager.register(module, name=entry.name)
        manager.check_pending()
        problem = _silent(module)
        commands = [command for offered in manager.hook.followspot_commands() for command in offered]
        options = [option for offered in manager.hook.followspot_plan_options() for option in offered]
        readers = [reader for offered in manager.hook.followspot_recording_readers() for reader in offered]
        scorers = [scorer for offered in manager.hook.followspot_scorers() for scorer in offered]
        keepers = [keeper for offered in manager.hook.followspot_keepers() for keeper in offered]
    except (Exception, SystemExit) as error:
        return _Offer(" ".join(f"{type(error).__name__}: {error}".split()))
    if not all(isinstance(command, Command) for command in commands):
        return _Offer("followspot_commands returns something that is no Command")
    if not all(isinstance(option, PlanOptions) for option in options):
        return _Offer("followspot_plan_options returns something that is no PlanOptions")
    if not all(isinstance(reader, RecordingReader) for reader in readers):
        return _Offer("followspot_recording_readers returns something that is no RecordingReader")
    if not all(isinstance(scorer, Scorer) for scorer in scorers):
        return _Offer("followspot_scorers returns something that is no Scorer")
    if not all(isinstance(keeper, Keeper) for keeper in keepers):
        return _Offer("followspot_keepers returns something that is no Keeper")
    return _Offer(problem, commands, options, readers, scorers, keepers)


def _silent(module: object) -> str:
    """Mistakes that pluggy ignores: hooks without the mark, a module without hooks."""
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
