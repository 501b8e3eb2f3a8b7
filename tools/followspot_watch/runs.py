"""Which run is meant, on this machine or under agents, and how it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from followspot.deploy.changes.change import chosen_here
from followspot.deploy.log.record import LogPage, page_from_data
from followspot.deploy.reachable import NoAnswer, RunHere, runs_here
from followspot.deploy.status import RunStatus, run_status_from_data
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data
from followspot.plugins.registry import use_plugin_files
from followspot.runtime.tapping import Tapping
from followspot.transport.zenoh_network import Network, network_from_data

if TYPE_CHECKING:
    from followspot.deploy.attach import Attachment

PATIENCE = 10.0
"""Seconds that a run may take to answer."""


@dataclass(frozen=True)
class Look:
    """A run that is looked at: its name, its plan as it was at first, how it is, and what it says.

    near: whether the operator's host is this one; status: gets how long to wait for it, s, after which it
    raises NoAnswer; log: the records after the one of a number; out: the folder of its outputs, where it is
    on this host; tap: puts sinks at ports; network: of one more session beside those of its hosts.
    """

    run: str
    plan: Plan
    near: bool
    status: Callable[[float], RunStatus]
    log: Callable[[int], LogPage]
    out: Callable[[], Path | None]
    tap: Callable[[Sequence[Tapping]], None]
    network: Callable[[], Network]

    def over(self) -> bool:
        """Whether the run has ended; one that does not answer has not."""
        try:
            return all(worker.phase == "over" for worker in self.status(PATIENCE).workers)
        except NoAnswer:
            return False
        except FollowspotError:
            return True


def run_here(wanted: str | None) -> RunHere:
    """The run of this machine that is meant: by graph, its name's beginning or its process, or the only one.

    Raises FollowspotError where there is none, or several.
    """
    runs = runs_here()
    run = chosen_here(runs, wanted)
    if run is None:
        what = "there is no run" + (f" {wanted}" if wanted else "")
        raise FollowspotError(f"{what}; runs on this machine: {_listing(runs)}")
    return run


def plan_here(run: RunHere) -> Plan:
    """Its plan, with its one-file plugins loaded. Raises FollowspotError."""
    plan = plan_from_data(run.ask("plan", PATIENCE))
    use_plugin_files(plan.plugin_files)
    return plan


@contextmanager
def looking(wanted: str | None, network: Network, plugin_files: Sequence[str] = ()) -> Iterator[Look]:
    """The run that is meant, here or under agents in reach. Raises FollowspotError where there is none.

    plugin_files: one-file plugins that the agents were given.
    """
    use_plugin_files(plugin_files)
    runs = runs_here()
    here = chosen_here(runs, wanted)
    if here is not None:
        yield _here(here)
        return
    from followspot.deploy.attach import attached

    with ExitStack() as stack:
        try:
            attachment = stack.enter_context(attached(network, wanted))
        except FollowspotError as error:
            raise FollowspotError(f"{error}; on this machine: {_listing(runs)}") from None
        yield _afar(attachment, network)


def _here(run: RunHere) -> Look:
    return Look(
        run=run.run,
        plan=plan_here(run),
        near=True,
        status=lambda patience: run_status_from_data(run.ask("status", patience)),
        log=lambda after: page_from_data(run.ask("log", PATIENCE, after=after)),
        out=lambda: Path(run.ask("where", PATIENCE)["out"]),
        tap=lambda taps: run.ask("tap", PATIENCE, taps=[asdict(tap) for tap in taps]),
        network=lambda: network_from_data(run.ask("where", PATIENCE)["network"]),
    )


def _afar(attachment: Attachment, network: Network) -> Look:
    coordinator = attachment.coordinator
    return Look(
        run=attachment.found.run,
        plan=coordinator.plan,
        near=False,
        status=lambda _: coordinator.status(),
        log=coordinator.records,
        out=lambda: None,
        tap=coordinator.tap,
        network=lambda: network,
    )


def _listing(runs: Sequence[RunHere]) -> str:
    return ", ".join(run.label for run in runs) or "none"
