"""The hooks that a package can implement, and what each offers: commands, options, readers, scorers, keepers.

A package names a module in the entry-point group `followspot.hooks.v1`; the module's functions marked with
`hookimpl` are the hooks. `followspot --help` imports these modules, so they import nothing heavy at the top.
`followspot.plugins.loaded_hooks` finds and loads them.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from inspect import cleandoc
from pathlib import Path
from typing import Any

import pluggy

PROJECT = "followspot"
"""Prefix of the names of hooks, as pluggy wants it."""

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


def _no_observer(_args: argparse.Namespace) -> AbstractContextManager[None]:
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
    watch: Callable[[argparse.Namespace], AbstractContextManager[None]] = _no_observer


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
