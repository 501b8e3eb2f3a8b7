"""Detached runs: started without an operator that stays, found again under agents, watched and stopped."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from followspot.control.dispatch import Request
from followspot.control.host import HostLost, RunOrder
from followspot.control.lifecycle import GetOrder, ListedRun, ListRuns, StopRun
from followspot.control.progress import OnProgress
from followspot.control.zenoh_rpc import RpcClient, agents
from followspot.errors import FollowspotError, InputError
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data
from followspot.operator.coordinator import Coordinator
from followspot.operator.discovery import (
    Agents,
    await_named,
    discovered_hosts,
    operator_session,
    searched_places,
)
from followspot.operator.host_plans import merged_plan, plan_conflict
from followspot.operator.named_run import NamedRun, chosen_run, is_named
from followspot.operator.new_order import new_order
from followspot.operator.remote.remote_host import RemoteHost
from followspot.operator.reporting.report import RunReport
from followspot.operator.run_dispatcher import run_dispatcher
from followspot.operator.run_handle import RunHandle
from followspot.operator.run_requests import RunMetadata
from followspot.transport.unreached import unreached
from followspot.transport.zenoh.network import AGENT, Network, secured
from followspot.worker.wiring import RunOptions


@dataclass(frozen=True)
class FoundRun:
    """A run under agents. hosts: names of the hosts whose agents list it; over: it has ended on all.

    detached: it goes on without an operator; owner: USER@HOST of the operator, as far as it is known; fired:
    frames done; age_s: s; folders: of its outputs, HOST:FOLDER.
    """

    run: str
    graph: str
    hosts: tuple[str, ...]
    over: bool
    pid: int | None = None
    detached: bool = False
    owner: str = ""
    fired: int = 0
    age_s: float = 0.0
    folders: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Text for lists of runs."""
        return f"{self.graph} ({self.run[:8]})"


def detach(plan: Plan, options: RunOptions, network: Network, media: Path) -> str:
    """Start a run that goes on without an operator; return its name.

    Raises FollowspotError if a worker has no host, or if not all workers get ready.
    """
    here = [worker.name for worker in plan.workers if not worker.host]
    if here:
        raise FollowspotError(
            f"workers without a host cannot be left alone: {', '.join(here)}; give them one with --host NAME"
        )
    order = new_order(plan, options, restart=True, detached=True)
    with discovered_hosts(plan, network, media) as (hosts, _):
        coordinator = Coordinator(plan, hosts, order)
        if not coordinator.begin():
            report = coordinator.watch()
            for host in hosts:
                host.close()
            raise FollowspotError("the run did not begin\n" + "\n".join(report.errors))
        _stop_polling(coordinator)
    return order.run


def find_runs(client: RpcClient, network: Network, on_gap: Callable[[str], None]) -> list[FoundRun]:
    """The runs of all agents that answer, the newest run of each agent last.

    network: leads to the agents; on_gap: gets a clause for what may hide further runs: an agent that does not
    answer, endpoints without an agent. Raises FollowspotError if an agent refuses.
    """
    by_run: dict[str, dict[str, ListedRun]] = {}
    heard = sorted(agents(client.session))
    named = () if network.connect in (AGENT, secured(AGENT)) else network.connect  # many have no agent here
    if len(heard) < max(len(named), bool(network.router), network.discover):
        why = unreached(named, network.certificates)
        heard_of = f"{f'only {len(heard)}' if heard else 'no'} agent is heard at {searched_places(network)}"
        on_gap(heard_of + f" ({why})" * bool(why))
    for agent in heard:
        if client.has_twins(agent):
            on_gap(f'several agents are named "{agent}", of which one is asked')
        try:
            for listed in client.ask(agent, ListRuns()):
                by_run.setdefault(listed.run, {})[agent] = listed
        except HostLost as error:
            on_gap(str(error))
    return [_found(run, hosts) for run, hosts in by_run.items()]


def runs_under(network: Network, on_gap: Callable[[str], None] = lambda clause: None) -> list[FoundRun]:
    """The runs of the agents that a network leads to; none if no agent answers.

    on_gap: see `find_runs`. Raises FollowspotError if the network cannot be used.
    """
    with operator_session(network) as session:
        await_named(session, network)
        return find_runs(RpcClient(session, network.own), network, on_gap)


def _found(run: str, hosts: Mapping[str, ListedRun]) -> FoundRun:
    """A run from the listing of each of its hosts."""
    listed = list(hosts.values())
    operator = listed[0].operator
    return FoundRun(
        run,
        listed[0].graph,
        tuple(hosts),
        all(one.over for one in listed),
        detached=listed[0].detached,
        owner="@".join(text for text in (operator.user, operator.name) if text),
        fired=max(one.fired for one in listed),
        age_s=max(one.age_s for one in listed),
        folders=tuple(f"{host}:{one.folder}" for host, one in hosts.items() if one.folder),
    )


class Attachment:
    """Watches a run of another operator; `stop` ends the watching, not the run."""

    def __init__(self, found: FoundRun, coordinator: Coordinator) -> None:
        self.found = found
        self.coordinator = coordinator
        self.stopped = False

    def stop(self) -> None:
        """Stop watching; the run goes on. Safe in a signal handler."""
        self.stopped = True
        self.coordinator.leave()

    def execute(self, on_progress: OnProgress | None = None) -> RunReport:
        """Block until the run ends, or until `stop`; return its report."""
        return self.coordinator.watch(on_progress)


@contextmanager
def attached_run(network: Network, wanted: str | None, here: Sequence[NamedRun] = ()) -> Iterator[Attachment]:
    """Watch a run under agents; it goes on after the block.

    wanted: see `connected_run`; here: runs of this machine that have other names. Raises FollowspotError if
    there is no such run, or several.
    """
    with operator_session(network) as session:
        await_named(session, network)
        client = RpcClient(session, network.own)
        gaps: list[str] = []
        runs = find_runs(client, network, gaps.append)
        where = "in reach" + "".join(f", though {gap}" for gap in gaps)
        run = chosen_run(_listing(here, runs, wanted), wanted, where)
        assert isinstance(run, FoundRun)  # no run of this machine has the name
        orders = {name: _order(client, name, run.run) for name in run.hosts}
        # without restart, because an observer must not resume the run
        watched = {name: replace(order, restart=False) for name, order in orders.items()}
        plans = {name: plan_from_data(order.plan) for name, order in orders.items()}
        plan, order = merged_plan(plans), orders[run.hosts[0]]
        unlisted = {worker.host for worker in plan.workers} - {"", *watched}
        watched |= dict.fromkeys(sorted(unlisted), watched[run.hosts[0]])
        hosts = [RemoteHost(client, name, order=order) for name, order in watched.items()]
        others = Agents(client)
        coordinator = Coordinator(plan, hosts, order, others=others, begun=True, age_s=run.age_s)
        coordinator.plan_conflict = plan_conflict(plans, plan)
        try:
            for host in hosts:
                host.watch(silent=host.name in unlisted)
            yield Attachment(run, coordinator)
            if all(host.status().all("over") for host in coordinator.hosts):
                for member in coordinator.hosts:
                    member.close()
        finally:
            _stop_polling(coordinator)


def _listing(here: Sequence[NamedRun], runs: Sequence[FoundRun], wanted: str | None) -> Sequence[NamedRun]:
    """All runs, each once; ended runs only if `wanted` names no run that goes on."""
    going = [run for run in runs if not run.over]
    known = {run.run for run in here}
    present = going if any(is_named(run, wanted) for run in going) else runs
    return [*here, *(run for run in present if run.run not in known)]


def handle_of(attachment: Attachment, network: Network) -> RunHandle:
    """A handle on the watched run. network: leads to its agents."""
    coordinator = attachment.coordinator

    def stop() -> None:
        for host in coordinator.hosts:  # no thread here watches the run, so `run.stop` would have no effect
            host.ask(StopRun())

    dispatcher = run_dispatcher(coordinator, RunMetadata(network=network), stop)

    def ask(request: Request, timeout: float) -> Any:
        try:
            return dispatcher.dispatch(request)
        except InputError as error:  # as the handle of a run on this machine raises
            raise FollowspotError(str(error)) from None

    return RunHandle(attachment.found.run, attachment.found.graph, ask)


def _stop_polling(coordinator: Coordinator) -> None:
    """Stop polling the hosts; the run goes on."""
    for host in coordinator.hosts:
        if isinstance(host, RemoteHost):
            host.leave()


def _order(client: RpcClient, host: str, run: str) -> RunOrder:
    order: RunOrder = client.ask(host, GetOrder(run=run))
    return replace(order, incarnations={}, fired={}, age_s=0.0)
