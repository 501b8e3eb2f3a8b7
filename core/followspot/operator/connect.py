"""Find the run that a word names: on this machine, else under agents."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Protocol, TypeVar

from followspot.errors import FollowspotError
from followspot.operator.control_socket import runs_here
from followspot.operator.run_handle import RunHandle
from followspot.transport.zenoh.network import Network

Run = TypeVar("Run", bound="Listed")


@contextmanager
def connected_run(wanted: str | None = None, network: Network | None = None) -> Iterator[RunHandle]:
    """A handle on the run that `wanted` names. The run goes on when the block ends.

    wanted: the graph's name, the beginning of the run's, or the process id of its operator; None names
    the only run; network: leads to agents, asked if no run of this machine has the name; None asks none.
    Raises FollowspotError if there is no such run, or several.
    """
    here = runs_here(wanted)
    found = _chosen_here(here, wanted)
    if found is not None:
        yield found
        return
    if network is None:
        raise FollowspotError(_missing(wanted, here))
    from followspot.operator.attach import attached, handle_of

    with ExitStack() as stack:
        try:
            attachment = stack.enter_context(attached(network, wanted))
        except FollowspotError as error:
            raise FollowspotError(f"{error}; on this machine: {listing(here)}") from None
        yield handle_of(attachment, network)


def run_here(wanted: str | None = None) -> RunHandle:
    """The same among the runs of this machine. Raises FollowspotError if there is no such run, or several."""
    here = runs_here(wanted)
    found = _chosen_here(here, wanted)
    if found is None:
        raise FollowspotError(_missing(wanted, here))
    return found


class Listed(Protocol):
    """A run in a list of runs. label: how the list shows it; pid: of its operator's process, if known."""

    @property
    def run(self) -> str: ...

    @property
    def graph(self) -> str: ...

    @property
    def pid(self) -> int | None: ...

    @property
    def label(self) -> str: ...


def chosen(runs: Sequence[Run], wanted: str | None) -> Run | None:
    """The run that `wanted` names, as in `connected_run`; None if there is none.

    Raises FollowspotError if there are several.
    """
    fitting = [
        run
        for run in runs
        if wanted is None or wanted in (run.graph, str(run.pid)) or run.run.startswith(wanted)
    ]
    if len(fitting) > 1:
        raise FollowspotError(f"there are several runs: {listing(fitting)}; name one by the word in brackets")
    return fitting[0] if fitting else None


def listing(runs: Sequence[Listed]) -> str:
    """Runs in one line."""
    return ", ".join(run.label for run in runs) or "none"


def _chosen_here(runs: Sequence[RunHandle], wanted: str | None) -> RunHandle | None:
    """As `chosen`. Raises NoAnswer if the run does not answer."""
    found = chosen(runs, wanted)
    if found is not None and not found.graph:
        found.status(timeout=0.5)  # raises NoAnswer
    return found


def _missing(wanted: str | None, runs: Sequence[RunHandle]) -> str:
    return f"there is no run {wanted or ''}".rstrip() + f"; runs on this machine: {listing(runs)}"
