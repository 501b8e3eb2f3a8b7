"""Runs that operators left with an agent when they died: ended by the next operator of the same machine."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress

from followspot.control.host import HostRefused
from followspot.control.lifecycle import CloseRun, ListRuns, StopRun
from followspot.control.observation import GetHostStatus
from followspot.control.origin import Origin
from followspot.control.zenoh_rpc import RpcClient
from followspot.host.operator_timeout import SILENT

_ENDING = 20.0
"""Seconds that workers may take to complete their outputs."""
_POLL_INTERVAL = 0.1
"""Seconds between two looks at them."""


def end_left_behind(client: RpcClient, host: str, here: Origin) -> Iterator[str]:
    """End what dead operators of this machine left with an agent; a line for each, and for who is silent.

    Raises HostLost, FollowspotError.
    """
    try:
        parts = client.ask(host, ListRuns())
    except HostRefused:  # who may not know may not begin a run either, and is told so then
        return
    for part in parts:
        if part.over or part.detached:
            continue
        name = f"run {part.run[:8]} of {part.graph}"
        if part.origin.dead(here):
            with suppress(HostRefused):  # somebody else was faster
                _end(client, host, part.run)
            yield f"{name} was left there by a process of this machine that has died; it was ended"
        elif part.silent_s > SILENT:
            yield (
                f"{name} goes on there, whose operator has been silent for {part.silent_s:.0f} s; "
                f"followspot attach {part.run[:8]} --stop ends it"
            )


def _end(client: RpcClient, host: str, run: str) -> None:
    """As its operator would: outputs are complete."""
    client.ask(host, StopRun(run=run))
    deadline = time.monotonic() + _ENDING
    while time.monotonic() < deadline:
        if client.ask(host, GetHostStatus(run=run)).all("over"):
            break
        time.sleep(_POLL_INTERVAL)
    client.ask(host, CloseRun(run=run))
