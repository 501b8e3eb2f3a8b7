"""Which runs there are, and the one that is meant: on this machine, else under agents in reach."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

from followspot.errors import FollowspotError
from followspot.operator.control_socket import runs_here
from followspot.operator.run_handle import RunHandle
from followspot.transport.zenoh.network import Network


@contextmanager
def connected_run(wanted: str | None = None, network: Network | None = None) -> Iterator[RunHandle]:
    """The run that is meant; leaving the block leaves the run to itself.

    wanted: the graph's name, the beginning of the run's, or the process id of its operator; None if there is
    one run; network: leads to agents, asked if no run of this machine is meant; None for none.
    Raises FollowspotError if there is no such run, or several.
    """
    here = runs_here(wanted)
    found = chosen(here, wanted)
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
            raise FollowspotError(f"{error}; on this machine: {_listing(here)}") from None
        yield handle_of(attachment, network)


def run_here(wanted: str | None = None) -> RunHandle:
    """The run of this machine that is meant, as `connected_run` has it. Raises FollowspotError."""
    here = runs_here(wanted)
    found = chosen(here, wanted)
    if found is None:
        raise FollowspotError(_missing(wanted, here))
    return found


def chosen(runs: Sequence[RunHandle], wanted: str | None) -> RunHandle | None:
    """The run that is meant; None if none is.

    Raises FollowspotError if several are, NoAnswer if the one that is meant does not answer.
    """
    fitting = [
        run
        for run in runs
        if wanted is None or wanted in (run.graph, str(run.pid)) or run.run.startswith(wanted)
    ]
    if len(fitting) == 1 and not fitting[0].graph:
        fitting[0].status(timeout=0.5)  # raises what is the matter with it
    if len(fitting) > 1:
        raise FollowspotError(
            f"there are several runs: {_listing(fitting)}; name one by what stands in brackets"
        )
    return fitting[0] if fitting else None


def _missing(wanted: str | None, runs: Sequence[RunHandle]) -> str:
    return f"there is no run {wanted or ''}".rstrip() + f"; runs on this machine: {_listing(runs)}"


def _listing(runs: Sequence[RunHandle]) -> str:
    return ", ".join(run.label for run in runs) or "none"
