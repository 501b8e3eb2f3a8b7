"""Following a run: its plan, its status again and again, and taps at its ports, asked for from outside."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import asdict
from itertools import count
from pathlib import Path
from typing import Any

from followspot.deploy.reachable import RunHere, runs_here
from followspot.deploy.status import RunStatus, run_status_from_data
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot_page.taps import tappings
from followspot_watch.runs import plan_here

_GLANCE = 0.1
"""Seconds between two looks for a run that has not begun."""
_PERIOD = 0.5
"""Seconds between two questions how the run is."""
_PLAN_EVERY = 10
"""Of so many questions one asks for the plan again: stages are swapped and parameters set."""
_PATIENCE = 10.0
"""Seconds that a run may take to answer; one that is setting up its stages takes long."""


async def found(pid: int) -> RunHere:
    """The run of a process, as soon as there is one."""
    while True:
        for run in await asyncio.to_thread(runs_here):
            if run.pid == pid:
                return run
        await asyncio.sleep(_GLANCE)


async def plan_of(run: RunHere) -> Plan:
    """The plan as it is now. Raises FollowspotError."""
    return await asyncio.to_thread(plan_here, run)


async def look(run: RunHere, plan: Plan, folder: Path, rate: float) -> None:
    """Let the run send previews to the folder. Raises FollowspotError."""
    taps = [asdict(tapping) for tapping in tappings(plan, folder, rate)]
    await asyncio.to_thread(run.ask, "tap", _PATIENCE, taps=taps)


async def follow(run: RunHere, take: Callable[[RunStatus], Any], show: Callable[[Plan], Any]) -> None:
    """Ask the run how it is, until it is there no more."""
    with contextlib.suppress(FollowspotError):
        for turn in count(1):
            take(run_status_from_data(await asyncio.to_thread(run.ask, "status", _PATIENCE)))
            if turn % _PLAN_EVERY == 0:
                show(await plan_of(run))
            await asyncio.sleep(_PERIOD)
