"""Follows a run: asks for its plan and its status, and places taps at its ports."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Collection, Sequence
from itertools import count
from pathlib import Path
from typing import Any

from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.library.handle import NoAnswer, RecorderState, RunHandle, RunStatus, Tapping, runs_here
from followspot_page.taps.remote_previews import RemotePreviews
from followspot_page.taps.shown_ports import ShownPort, plotted_ports, shown_ports, tappings

_START_POLL_INTERVAL = 0.1
"""Poll interval, s, until the run has started."""
_PERIOD = 0.5
"""Poll interval of the status, s."""
_ANSWER = 1.0
"""Seconds to wait for the status before the page shows the last one as old."""
_PLAN_EVERY = 10
"""Every so many polls, also ask for the plan, which changes by swaps and parameters."""


async def found(pid: int) -> RunHandle:
    """The run of a process, as soon as it exists."""
    while True:
        for run in await asyncio.to_thread(runs_here):
            if run.pid == pid and run.graph:  # a run that does not answer yet has no name
                return run
        await asyncio.sleep(_START_POLL_INTERVAL)


async def plan_of(run: RunHandle) -> Plan:
    """The present plan. Raises FollowspotError."""
    return await asyncio.to_thread(run.plan)


async def remote_previews(run: RunHandle, take: Callable[[str, bytes], Any]) -> RemotePreviews | None:
    """Previews from the run's other hosts; None if it has none. Raises FollowspotError."""
    network = (await asyncio.to_thread(run.metadata)).network
    return None if network is None else await RemotePreviews.open(network, run.run, take)


class Sight:
    """The page's taps: one at every port that it can show, on the present host of each stage.

    folder: of the page, where taps of this host send to; rate: pictures per second; remote: previews from
    other hosts, if the run has any.
    """

    def __init__(self, run: RunHandle, folder: Path, rate: float, remote: RemotePreviews | None) -> None:
        self._run = run
        self._folder = folder
        self._rate = rate
        self._remote = remote
        self.plotted: Collection[str] = ()
        """Ports whose figures browsers plot."""
        self._ports: tuple[ShownPort, ...] = ()
        self._taps: Sequence[Tapping] = ()
        self._turning = asyncio.Lock()

    async def turn_to(self, plan: Plan) -> None:
        """Place taps for the plan's present ports. Raises FollowspotError."""
        async with self._turning:
            found = (*shown_ports(plan), *plotted_ports(plan, self.plotted))
            if found == self._ports:
                return
            taps = tappings(found, self._folder, self._rate)
            await asyncio.to_thread(self._run.tap, taps)
            await self._untap([tap for tap in self._taps if tap not in taps])
            if self._remote is not None:
                self._remote.select(found)
            self._ports, self._taps = found, taps

    async def close(self) -> None:
        """Remove the taps."""
        await self._untap(self._taps)

    async def _untap(self, taps: Sequence[Tapping]) -> None:
        if taps:
            await asyncio.to_thread(self._run.untap, taps)


async def follow(
    run: RunHandle,
    sight: Sight,
    take: Callable[[RunStatus | None], Any],
    show: Callable[[Plan], Any],
    keep: Callable[[RecorderState | None], Any],
) -> None:
    """Poll the run until it has ended; `take` receives None if the run does not answer.

    keep: receives what its flight recorder holds.
    """
    with contextlib.suppress(FollowspotError):
        for turn in count(1):
            try:
                status = await asyncio.to_thread(run.status, _ANSWER)
                take(status)
                if run.pid is None and all(worker.phase == "over" for worker in status.workers):
                    return  # a run under agents, whose end no operator reports
                keep(await _kept(run))
                if turn % _PLAN_EVERY == 0:
                    plan = await plan_of(run)
                    show(plan)
                    await sight.turn_to(plan)
            except NoAnswer:
                take(None)
            await asyncio.sleep(_PERIOD)


async def _kept(run: RunHandle) -> RecorderState | None:
    """The state of the run's flight recorder; None if the run has none."""
    with contextlib.suppress(FollowspotError):
        return await asyncio.to_thread(run.kept)
    return None
