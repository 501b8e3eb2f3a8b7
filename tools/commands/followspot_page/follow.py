"""Following a run: its plan, its status again and again, and taps at its ports, asked for from outside."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.library.handle import NoAnswer, RunHandle, RunStatus, runs_here
from followspot_page.far import FarPreviews
from followspot_page.taps import ShownPort, shown_ports, tappings

_GLANCE = 0.1
"""Seconds between two looks for a run that has not begun."""
_PERIOD = 0.5
"""Seconds between two questions how the run is."""
_ANSWER = 1.0
"""Seconds to wait for its status until browsers are told again how old the last one is."""
_PLAN_EVERY = 10
"""Of so many questions one asks for the plan again: stages are swapped and parameters set."""


async def found(pid: int) -> RunHandle:
    """The run of a process, as soon as there is one."""
    while True:
        for run in await asyncio.to_thread(runs_here):
            if run.pid == pid and run.graph:  # else it does not answer yet
                return run
        await asyncio.sleep(_GLANCE)


async def plan_of(run: RunHandle) -> Plan:
    """The plan as it is now. Raises FollowspotError."""
    return await asyncio.to_thread(run.plan)


async def far_previews(run: RunHandle, take: Callable[[str, bytes], Any]) -> FarPreviews | None:
    """The way from the run's other hosts; None where it has none. Raises FollowspotError."""
    network = (await asyncio.to_thread(run.surroundings)).network
    return None if network is None else await FarPreviews.open(network, run.run, take)


class Sight:
    """What the page looks at: every port that can be shown, wherever its stage is now.

    folder: of the page, which taps here send to; rate: pictures in a second; far: previews from other hosts,
    where the run has any.
    """

    def __init__(self, run: RunHandle, folder: Path, rate: float, far: FarPreviews | None) -> None:
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
        await asyncio.to_thread(self._run.tap, tappings(found, self._folder, self._rate))
        if self._far is not None:
            self._far.look(found)
        self._ports = found


async def follow(
    run: RunHandle, sight: Sight, take: Callable[[RunStatus | None], Any], show: Callable[[Plan], Any]
) -> None:
    """Ask the run how it is, until it is there no more; `take` is given None where it does not answer."""
    with contextlib.suppress(FollowspotError):
        for turn in count(1):
            try:
                take(await asyncio.to_thread(run.status, _ANSWER))
                if turn % _PLAN_EVERY == 0:
                    plan = await plan_of(run)
                    show(plan)
                    await sight.turn_to(plan)
            except NoAnswer:
                take(None)
            await asyncio.sleep(_PERIOD)
