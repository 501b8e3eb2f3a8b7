"""Which run is meant, on this machine or under agents, and how it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from followspot.deploy.changes.change import chosen_here
from followspot.deploy.log.record import LogPage, page_from_data
from followspot.deploy.reachable import RunHere, runs_here
from followspot.deploy.status import RunStatus, run_status_from_data
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data
from followspot.plugins.registry import use_plugin_files
from followspot.transport.zenoh_network import Network

_PATIENCE = 10.0
"""Seconds that a run may take to answer."""


@dataclass(frozen=True)
class Look:
    """A run that is looked at: its name, its plan as it was at first, how it is, and what it said.

    log: the records after the one of a number.
    """

    run: str
    plan: Plan
    status: Callable[[], RunStatus]
    log: Callable[[int], LogPage]


def run_here(wanted: str | None) -> RunHere:
    """The run of this machine that is meant: by graph, its name's beginning or its process, or the only one.

    Raises FollowspotError where there is none, or several.
    """
    runs = runs_here()
    run = chosen_here(runs, wanted)
    if run is None:
        listing = ", ".join(f"{run.graph} ({run.run[:8]})" for run in runs) or "none"
        what = "there is no run" + (f" {wanted}" if wanted else "")
        raise FollowspotError(f"{what}; runs on this machine: {listing}")
    return run


def plan_here(run: RunHere) -> Plan:
    """Its plan, with its one-file plugins loaded. Raises FollowspotError."""
    plan = plan_from_data(run.ask("plan", _PATIENCE))
    use_plugin_files(plan.plugin_files)
    return plan


@contextmanager
def looking(wanted: str | None, network: Network) -> Iterator[Look]:
    """The run that is meant, here or under agents in reach. Raises FollowspotError where there is none."""
    here = chosen_here(runs_here(), wanted)
    if here is not None:
        run = here
        yield Look(
            run.run,
            plan_here(run),
            lambda: run_status_from_data(run.ask("status", _PATIENCE)),
            lambda after: page_from_data(run.ask("log", _PATIENCE, after=after)),
        )
        return
    from followspot.deploy.attach import attached

    with attached(network, wanted) as attachment:
        coordinator = attachment.coordinator
        yield Look(attachment.found.run, coordinator.plan, coordinator.status, coordinator.records)
