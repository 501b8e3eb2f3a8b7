"""`followspot runs`: the runs in reach."""

from __future__ import annotations

import argparse
import json
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass

from followspot.cli.agent_options import network_of
from followspot.errors import FollowspotError, shown
from followspot.library.attach import FoundRun, runs_under
from followspot.library.handle import RunHandle, runs_here, user_of
from followspot.tables.terminal import table

_ANSWER = 1.0
"""Seconds that a run has to answer."""
_WORD = 8
"""Letters of a run's name that name it in other commands."""


@dataclass(frozen=True)
class Listed:
    """A run in the list. process: of its operator, None under agents; frames, age_s, folder: None if
    unknown; keeps_s: seconds that its flight recorder is to hold, None without one; owner: who started
    it, and the host of the operator if it is another.
    """

    run: str
    graph: str
    hosts: tuple[str, ...]
    state: str
    process: int | None = None
    frames: int | None = None
    age_s: float | None = None
    folder: str | None = None
    keeps_s: float | None = None
    owner: str = ""


def runs(args: argparse.Namespace) -> int:
    """Print the list."""
    here = [listed_here(run) for run in runs_here()]
    known = {run.run for run in here}
    there = [listed_there(run) for run in runs_under(network_of(args), _warn) if run.run not in known]
    found = [*here, *there]
    if args.json:
        print(json.dumps([asdict(run) for run in found]))
    else:
        print(_table(found) if found else "there are no runs in reach")
    return 0


def _warn(gap: str) -> None:
    """Say why the list may lack runs."""
    print(f"followspot: warning: {gap}: the list may lack runs", file=sys.stderr)


def listed_here(run: RunHandle) -> Listed:
    """A run of this machine."""
    try:
        status, metadata, plan = run.status(_ANSWER), run.metadata(), run.outline()
    except FollowspotError:
        return Listed(run.run, run.graph, (), "does not answer", run.pid, owner=user_of(run.pid or 0))
    hosts = tuple(dict.fromkeys(worker.host or "this host" for worker in plan.workers))
    paused = any(stage.state == "paused" for worker in status.workers for stage in worker.stages)
    kept = None
    with suppress(FollowspotError):
        kept = run.kept()
    return Listed(
        run.run,
        run.graph,
        hosts,
        "paused" if paused else "running",
        run.pid,
        status.fired,
        round(time.time() - metadata.began, 1) if metadata.began else None,
        str(metadata.out) if metadata.out else None,
        kept.seconds if kept else None,
        user_of(run.pid or 0),
    )


def listed_there(run: FoundRun) -> Listed:
    """A run under agents."""
    state = "ended" if run.over else "detached" if run.detached else "running"
    return Listed(
        run.run,
        run.graph,
        run.hosts,
        state,
        None,
        run.fired,
        round(run.age_s, 1),
        ", ".join(run.folders) or None,
        owner=run.owner,
    )


def _table(found: list[Listed]) -> str:
    head = ("run", "graph", "on", "state", "owner", "frames", "age", "process", "folder")
    return table(head, [tuple(_cells(run)) for run in found])


def _cells(run: Listed) -> list[str]:
    keeps = f", keeps {run.keeps_s:g} s" if run.keeps_s else ""
    age = "" if run.age_s is None else _age(run.age_s)
    known = ("" if value is None else str(value) for value in (run.frames, age, run.process, run.folder))
    cells = [run.run[:_WORD], run.graph, ", ".join(run.hosts), run.state + keeps, run.owner, *known]
    return [shown(cell) for cell in cells]


def _age(seconds: float) -> str:
    """An age in the largest unit that says enough."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s" if minutes else f"{rest} s"
