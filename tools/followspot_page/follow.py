"""Following a run: its plan, its status again and again, and taps at its ports, asked for from outside."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import asdict
from itertools import count
from pathlib import Path
from typing import Any

from followspot.deploy.reachable import NoAnswer, RunHere, runs_here
from followspot.deploy.status import RunStatus, run_status_from_data
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.transport.zenoh_network import network_from_data
from followspot_page.far import FarPreviews
from followspot_page.taps import ShownPort, shown_ports, tappings
from followspot_watch.runs import plan_here

_GLANCE = 0.1
"""Seconds between two looks for a run that has not begun."""
_PERIOD = 0.5
"""Seconds between two questions how the run is."""
_PLAN_EVERY = 10
"""Of so many questions one asks for the plan again: stages are swapped and parameters set."""
_PATIENCE = 10.0
"""Seconds that a run may take to answer; one that is setting up its stages takes long."""
_ANSWER = 1.0
"""Seconds to wait for its status until browsers are told again how old the last one is."""


async def found(pid: int) -> RunHere:
    """The run of a process, as soon as there is one."""
    while True:
        for run in await asyncio.to_thread(runs_here):
            if run.pid == pid and run.graph:  # else it does not answer yet
                return run
        await asyncio.sleep(_GLANCE)


async def plan_of(run: RunHere) -> Plan:
    """The plan as it is now. Raises FollowspotError."""
    return await asyncio.to_thread(plan_here, run)


async def far_previews(run: RunHere, take: Callable[[str, bytes], Any]) -> FarPreviews | None:
    """The way from the run's other hosts; None where it has none. Raises FollowspotError."""
    where = await asyncio.to_thread(run.ask, "where", _PATIENCE)
    if where["network"] is None:
        return None
    return await FarPreviews.open(network_from_data(where["network"]), run.run, take)


class Sight:
    """What the page looks at: every port that can be shown, wherever its stage is now.

    folder: of the page, which taps here send to; rate: pictures in a second; far: previews from other hosts,
    where the run has any.
    """

    def __init__(self, run: RunHere, folder: Path, rate: float, far: FarPreviews | None) -> None:
        self._run = run
        self._folder = folder
        self._rate = rate
        self._far = far
        self._ports: tuple[ShownPort, ...] = ()

    async def turn_to(self, plan: Plan) -> None:
        """Look where the plan has the stages. Raises FollowspotError."""
        found = shown_ports(plan)
        if found == self._ports:
            return
        taps = [asdict(tapping) for tapping in tappings(found, self._folder, self._rate)]
        await asyncio.to_thread(self._run.ask, "tap", _PATIENCE, taps=taps)
        if self._far is not None:
            self._far.look(found)
        self._ports = found


async def follow(
    run: RunHere, sight: Sight, take: Callable[[RunStatus | None], Any], show: Callable[[Plan], Any]
) -> None:
    """Ask the run how it is, until it is there no more; `take` is given None where it does not answer."""
    with contextlib.suppress(FollowspotError):
        for turn in count(1):
            try:
                take(run_status_from_data(await asyncio.to_thread(run.ask, "status", _ANSWER)))
                if turn % _PLAN_EVERY == 0:
                    plan = await plan_of(run)
                    show(plan)
                    await sight.turn_to(plan)
            except NoAnswer:
                take(None)
            await asyncio.sleep(_PERIOD)
