"""Handles on runs that are found by their names: on this machine, or under agents."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from followspot.control.unix_socket import served_here
from followspot.operator.named_run import chosen_run, is_named
from followspot.operator.run_handle import RunHandle
from followspot.transport.zenoh.network import Network


@contextmanager
def connected_run(wanted: str | None = None, network: Network | None = None) -> Iterator[RunHandle]:
    """A handle on the run that `wanted` names. The run goes on when the block ends.

    wanted: the graph's name, the beginning of the run's, or the process id of its operator; None names
    the only run; network: leads to agents, asked if no run of this machine has the name; None asks none.
    Raises FollowspotError if there is no such run, or several.
    """
    here = runs_here(wanted)
    if network is None or any(is_named(run, wanted) for run in here):
        yield _answering(chosen_run(here, wanted, "on this machine"))
        return
    from followspot.operator.attach import attached_run, handle_of  # brings Zenoh

    with attached_run(network, wanted, here) as attachment:
        yield handle_of(attachment, network)


def run_here(wanted: str | None = None) -> RunHandle:
    """A handle on a run of this machine, found as by `connected_run`.

    Raises FollowspotError if there is no such run, or several.
    """
    return _answering(chosen_run(runs_here(wanted), wanted, "on this machine"))


def runs_here(wanted: str | None = None) -> list[RunHandle]:
    """The user's runs on this machine, sorted by name; see `served_here`."""
    return [RunHandle(found.run, found.graph, found.ask, found.pid) for found in served_here(wanted)]


def _answering(run: RunHandle) -> RunHandle:
    """The run. Raises NoAnswer if its process does not answer."""
    if not run.graph:
        run.status(timeout=0.5)
    return run
