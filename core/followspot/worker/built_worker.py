"""A worker whose stages are built: the handlers of its host's orders, until it has ended."""

from __future__ import annotations

import socket
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from followspot.control.checkpoint import state_from_data
from followspot.control.dispatch import Handlers
from followspot.control.lifecycle import EndWorkers
from followspot.control.pipe import ChannelClosed
from followspot.control.swap import ChangeOrder
from followspot.control.worker_orders import LeaveRun, SendStates, SetClock, TakeRing
from followspot.graph.plan_data import plan_from_data
from followspot.worker.change.hot_swap import HotSwap
from followspot.worker.change.rewiring import Rewiring
from followspot.worker.ledger import COLUMNS, Ledger
from followspot.worker.reporting.host_reporter import HostReporter
from followspot.worker.reporting.report import Warnings
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler
from followspot.worker.taps.worker_taps import WorkerTaps
from followspot.worker.wiring import RunOptions, Wiring
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

if TYPE_CHECKING:
    from followspot.worker.taps.published_ports import PublishedPort


class BuiltWorker:
    """The stages of one worker with their edges, taps and changes.

    name: of the worker; ledger, options: those that the stages were built with; reporter: sends checkpoints
    and the answers to changes.
    """

    def __init__(
        self,
        name: str,
        scheduler: Scheduler,
        edge_factory: WorkerEdgeFactory,
        ledger: Ledger,
        options: RunOptions,
        reporter: HostReporter,
        warnings: Warnings,
    ) -> None:
        self.name = name
        self.scheduler = scheduler
        self.edge_factory = edge_factory
        self._ledger = ledger
        self.options = options
        self._reporter = reporter
        self._warnings = warnings
        self._taps = WorkerTaps(name, scheduler, edge_factory, partial(warnings.add, "taps"))
        self._change = HotSwap(scheduler, reporter.send_change, self._rewiring)
        self._published: list[PublishedPort] = []

    @property
    def handlers(self) -> Handlers:
        """The handlers of all orders to a running worker."""
        return {
            **self.scheduler.handlers,
            **self._taps.handlers,
            EndWorkers: lambda order: self.give_up(order.workers),
            TakeRing: lambda order, end: self.edge_factory.take(
                self.scheduler, order, socket.socket(fileno=end)
            ),
            SendStates: lambda _: self._reporter.send_states(self.scheduler),
            SetClock: self._set_clock,
            LeaveRun: self._leave_run,
            ChangeOrder: self._change.carry_out,
        }

    def give_up(self, workers: Collection[str]) -> None:
        """These workers have ended: nothing more comes from the other ends of their edges."""
        plan, ended = self.edge_factory.plan, set(workers)
        self.scheduler.ends.give_up(
            {
                number * COLUMNS
                for number, edge in plan.numbered()
                if not ended.isdisjoint(map(plan.worker_of, (edge.from_stage, edge.to_stage)))
            }
        )

    def restore(self, states: Mapping[str, Any]) -> None:
        """Restore checkpoints, by stage, of a worker that died; warn of those that cannot be restored."""
        for runner in self.scheduler.runners:
            if runner.name in states:
                try:
                    runner.stage.restore(state_from_data(states[runner.name]))
                except Exception as error:
                    self._warnings.add(
                        runner.name, f"it starts without its former state, which cannot be restored: {error}"
                    )

    def publish_ports(self) -> None:
        """Publish the ports that are not published yet, if the worker has a Zenoh session."""
        if self.edge_factory.zenoh.session is not None:
            from followspot.worker.taps.published_ports import published

            self._published += published(self.edge_factory, self.scheduler, self._published)

    def run(self) -> None:
        """Run the stages to the end of all streams. Raises StageError, StuckError, ChannelClosed."""
        try:
            self.scheduler.run()
        finally:
            self._change.close()

    def close(self) -> None:
        """Close taps, stages and the ends of edges."""
        self._taps.close()
        self.scheduler.close()

    def _rewiring(self, data: dict[str, Any]) -> Rewiring:
        """Build the change of this worker to a new plan, in JSON types. Raises FollowspotError."""
        edge_factory = self.edge_factory.for_plan(plan_from_data(data))
        rewired = partial(self._rewired, edge_factory)
        wiring = Wiring(edge_factory.plan)
        return Rewiring(self.scheduler, wiring, self.name, self._ledger, self.options, edge_factory, rewired)

    def _rewired(self, edge_factory: WorkerEdgeFactory, new: Sequence[StageRunner]) -> None:
        """Note that the worker runs another plan now.

        edge_factory: made for the plan; new: stages that the plan adds here.
        """
        self.edge_factory.adopt(edge_factory)
        for runner in new:
            self._warnings.begin(runner.name)
        self.publish_ports()

    def _set_clock(self, order: SetClock) -> None:
        self.options.clock.correct(*order.correction)

    def _leave_run(self, _: LeaveRun) -> None:
        """Send checkpoints and end the worker in the middle of its streams. Raises ChannelClosed."""
        self._reporter.send_states(self.scheduler)
        raise ChannelClosed("this worker's stages move to another worker")
