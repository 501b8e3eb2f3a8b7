"""Run a plan: in this thread where it has one worker, else under an agent in this process and others."""

from __future__ import annotations

import signal
from dataclasses import asdict, dataclass
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

from followspot.deploy.coordinator import Coordinator, order_of
from followspot.deploy.host_run import HostRun
from followspot.deploy.local import LocalRun, OnProgress
from followspot.deploy.log.run_log import OnLog
from followspot.deploy.reachable import reachable
from followspot.deploy.report import RunReport
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_to_data
from followspot.runtime.tapping import Tapping
from followspot.runtime.wiring import RunOptions
from followspot.transport.zenoh_network import Network


class Run(Protocol):
    """What can be executed, and stopped meanwhile."""

    stopped: bool

    def stop(self) -> None:
        """End the sources; safe in a signal handler."""

    def execute(self, on_progress: OnProgress | None = None) -> RunReport:
        """Run to the end."""


def run_plan(
    plan: Plan,
    options: RunOptions,
    on_progress: OnProgress | None = None,
    *,
    network: Network = Network(),
    media: Path = Path(),
    restart: bool = False,
    on_log: OnLog | None = None,
) -> RunReport:
    """Run to the end of all sources, or until it is interrupted; see `interruptible`.

    network: leads to the agents of other hosts that the plan names; media: folder here whose files agents
    have below their own --media folder; restart: whether workers that die are started again in a replay,
    too, as they are in live runs; on_log: gets each record of the log. Raises InputError where an agent is
    missing.
    """
    order = order_of(plan, options, restart=restart or any(stage.live for stage in plan.stages))
    if network.public or any(worker.host for worker in plan.workers):
        from followspot.deploy.reach import reached

        with reached(plan, network, media) as (hosts, others):
            around = Surroundings(options.out, network)
            return _changeable(Coordinator(plan, hosts, order, on_log, others), on_progress, around)
    if len(plan.workers) == 1:
        return _changeable(LocalRun(plan, options, on_log), on_progress, Surroundings(options.out))
    coordinator = Coordinator(plan, [HostRun("")], order, on_log)
    return _changeable(coordinator, on_progress, Surroundings(options.out))


@dataclass(frozen=True)
class Surroundings:
    """Of a run: its folder here, and the network of its other hosts, where it has any."""

    out: Path
    network: Network | None = None

    def to_data(self) -> dict[str, Any]:
        """JSON types; the network is that of one more session beside those of the run."""
        network = self.network and asdict(self.network.for_worker(self.network.connect))
        return {"out": str(self.out.resolve()), "network": network}


def _changeable(
    run: Coordinator | LocalRun, on_progress: OnProgress | None, around: Surroundings
) -> RunReport:
    """Execute; meanwhile other processes of the user can find the run, look at it and change it."""

    def change(words: list[str], folder: str, fresh: bool = False) -> dict[str, Any]:
        return run.change([str(word) for word in words], Path(folder), fresh=bool(fresh)).to_data()

    def move(stages: list[str], place: str) -> dict[str, Any]:
        return run.move([str(stage) for stage in stages], str(place)).to_data()

    with reachable(
        run.name, run.plan.graph, {**_looking(run), "where": around.to_data, "change": change, "move": move}
    ):
        return interruptible(run, on_progress)


def _looking(run: Coordinator | LocalRun) -> dict[str, Any]:
    """What those who look on can ask for."""

    def tap(taps: list[dict[str, Any]]) -> None:
        run.tap([Tapping(str(t["port"]), str(t["uses"]), dict(t["params"])) for t in taps])

    return {
        "plan": lambda: plan_to_data(run.plan),
        "status": lambda: run.status().to_data(),
        "log": lambda after: run.records(int(after)).to_data(),
        "tap": tap,
    }


def interruptible(run: Run, on_progress: OnProgress | None = None) -> RunReport:
    """Execute; Ctrl-C and SIGTERM end the sources, and outputs are complete either way.

    A second Ctrl-C raises KeyboardInterrupt. Call from the main thread.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        if run.stopped and number == signal.SIGINT:
            raise KeyboardInterrupt
        run.stop()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        return run.execute(on_progress)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
