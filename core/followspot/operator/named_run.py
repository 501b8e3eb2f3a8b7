"""Finds the run that a user names: one rule for runs of this machine and for runs under agents."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

from followspot.errors import FollowspotError


class NamedRun(Protocol):
    """A run that a user may name. label: how the list shows it; pid: of its operator's process, if known."""

    @property
    def run(self) -> str: ...

    @property
    def graph(self) -> str: ...

    @property
    def pid(self) -> int | None: ...

    @property
    def label(self) -> str: ...


Run = TypeVar("Run", bound=NamedRun)


def is_named(run: NamedRun, wanted: str | None) -> bool:
    """True if `wanted` names this run, as `connected_run` takes it."""
    return wanted is None or wanted in (run.graph, str(run.pid)) or run.run.startswith(wanted)


def chosen_run(runs: Sequence[Run], wanted: str | None, where: str) -> Run:
    """The run that `wanted` names.

    where: these runs are, for the error message. Raises FollowspotError if there is no such run, or several.
    """
    fitting = [run for run in runs if is_named(run, wanted)]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        raise FollowspotError(f"there are several runs: {_text(fitting)}; name one by the word in brackets")
    raise FollowspotError(f"there is no run {wanted or ''}".rstrip() + f"; runs {where}: {_text(runs)}")


def _text(runs: Sequence[NamedRun]) -> str:
    """Runs in one line."""
    return ", ".join(run.label for run in runs) or "none"
