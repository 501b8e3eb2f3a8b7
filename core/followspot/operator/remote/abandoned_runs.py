"""Abandoned runs: an agent still has them, but their operator died; the next operator here ends them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress

from followspot.control.host import HostRefused
from followspot.control.lifecycle import CloseRun, ListRuns, StopRun
from followspot.control.observation import GetHostStatus
from followspot.control.process_identity import ProcessIdentity
from followspot.control.zenoh_rpc import RpcClient
from followspot.host.operator_timeout import SILENT

_END_TIMEOUT = 20.0
"""Seconds that workers may take to complete their outputs."""
_POLL_INTERVAL = 0.1
"""Seconds between two polls of the workers."""


def end_abandoned_runs(client: RpcClient, host: str, here: ProcessIdentity) -> Iterator[str]:
    """End the runs at an agent whose operators were processes of this machine that have died.

    Yields a line for each run that was ended, and for each run whose operator has been silent for long.
    Raises HostLost if the agent does not answer, FollowspotError if it refuses.
    """
    try:
        runs = client.ask(host, ListRuns())
    except HostRefused:  # an operator without this right cannot start a run either; PrepareRun says so
        return
    for run in runs:
        if run.over or run.detached:
            continue
        name = f"run {run.run[:8]} of {run.graph}"
        if run.operator.dead(here):
            with suppress(HostRefused):  # another operator has ended it already
                _end_run(client, host, run.run)
            yield f"{name} was left there by a process of this machine that has died; it was ended"
        elif run.silent_s > SILENT:
            yield (
                f"{name} goes on there, whose operator has been silent for {run.silent_s:.0f} s; "
                f"followspot attach --run {run.run[:8]} --stop ends it"
            )


def _end_run(client: RpcClient, host: str, run: str) -> None:
    """Stop a run as its operator would, so that its outputs are complete."""
    client.ask(host, StopRun(run=run))
    deadline = time.monotonic() + _END_TIMEOUT
    while time.monotonic() < deadline:
        if client.ask(host, GetHostStatus(run=run)).all("over"):
            break
        time.sleep(_POLL_INTERVAL)
    client.ask(host, CloseRun(run=run))
