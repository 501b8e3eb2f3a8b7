"""Which run on this machine is meant."""

from __future__ import annotations

from followspot.deploy.change import chosen_here
from followspot.deploy.reachable import RunHere, runs_here
from followspot.errors import FollowspotError


def run_here(wanted: str | None) -> RunHere:
    """The run that is meant: by its graph, the beginning of its name, its process, or the only one.

    Raises FollowspotError where there is none, or several.
    """
    runs = runs_here()
    run = chosen_here(runs, wanted)
    if run is None:
        listing = ", ".join(f"{run.graph} ({run.run[:8]})" for run in runs) or "none"
        what = "there is no run" + (f" {wanted}" if wanted else "")
        raise FollowspotError(f"{what}; runs on this machine: {listing}")
    return run
