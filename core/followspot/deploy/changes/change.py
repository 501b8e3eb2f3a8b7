"""Change a graph that runs: `followspot swap`, `set` and `move`, and whoever else wants to."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from followspot.deploy.changes.changed import Changed, Moved
from followspot.deploy.reachable import RunHere, runs_here
from followspot.errors import FollowspotError, InputError
from followspot.transport.zenoh_network import Network


def change(
    wanted: str | None,
    words: Sequence[str],
    *,
    fresh: bool = False,
    folder: Path = Path(),
    network: Network | None = None,
) -> Changed:
    """Swap stages (`fuse=balls.mean`) and set parameters (`color.similarity=0.7`) of a running graph.

    Successors are built beside the stages that work, and take over between two firings, all or none; they
    carry on from the state of the old ones where both know how, unless `fresh`. wanted: the graph's name, the
    beginning of the run's, or its process id; None where one run is there; folder: what paths are relative
    to; network: leads to agents whose runs are looked at where this machine has none that is meant.

    Raises FollowspotError with the reason where it cannot be; then everything goes on as it was.
    """
    here = runs_here(wanted)
    run = chosen_here(here, wanted)
    if run is not None:
        answer = run.ask("change", words=list(words), folder=str(folder.absolute()), fresh=fresh)
        return Changed.from_data(answer)
    if network is None:
        raise FollowspotError(_none(wanted, here))
    from followspot.deploy.attach import attached

    with attached(network, wanted) as attachment:
        try:
            return attachment.coordinator.change(words, folder, fresh=fresh)
        except InputError as error:  # one answer, wherever the run is
            raise FollowspotError(str(error)) from None


def move(wanted: str | None, stages: Sequence[str], place: str, *, network: Network | None = None) -> Moved:
    """Bring stages of a live run to another worker or host that takes part in it.

    wanted, network: as for `change`. Workers whose stages or kinds of edges change begin anew with the state
    of their stages, and what is under way to and from them is lost and counted. Raises FollowspotError with
    the reason where it cannot be.
    """
    here = runs_here(wanted)
    run = chosen_here(here, wanted)
    if run is not None:
        return Moved.from_data(run.ask("move", stages=list(stages), place=place))
    if network is None:
        raise FollowspotError(_none(wanted, here))
    from followspot.deploy.attach import attached

    with attached(network, wanted) as attachment:
        try:
            return attachment.coordinator.move(stages, place)
        except InputError as error:
            raise FollowspotError(str(error)) from None


def chosen_here(runs: Sequence[RunHere], wanted: str | None) -> RunHere | None:
    """The run on this machine that is meant; None where none is.

    Raises FollowspotError where several are, and where the one that is meant does not answer.
    """
    fitting = [
        run
        for run in runs
        if wanted is None or wanted in (run.graph, str(run.pid)) or run.run.startswith(wanted)
    ]
    if len(fitting) > 1:
        listing = ", ".join(run.label for run in fitting)
        raise FollowspotError(f"there are several runs: {listing}; name one by what stands in brackets")
    if fitting and not fitting[0].graph:
        raise fitting[0].silent()
    return fitting[0] if fitting else None


def _none(wanted: str | None, runs: Sequence[RunHere]) -> str:
    listing = ", ".join(run.label for run in runs) or "none"
    return f"there is no run {wanted or ''}".rstrip() + f"; runs on this machine: {listing}"
