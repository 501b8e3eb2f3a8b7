"""A worker process: `python -m followspot.worker.main FD`, where FD is its control channel.

The host sends the plan; the worker builds its stages, says that it is ready, waits for the start, runs,
and reports. When the host dies, the worker ends its sources, completes its outputs and exits.
"""

from __future__ import annotations

import signal
import socket
import sys
from collections.abc import Collection, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from followspot.control.checkpoint import state_from_data
from followspot.control.dispatch import Handlers
from followspot.control.lifecycle import EndWorkers, StartRun, StopRun
from followspot.control.pipe import Channel, ChannelClosed, Received
from followspot.control.swap import ChangeOrder
from followspot.control.worker_messages import Built, Done, Failed, Listening, Ready
from followspot.control.worker_orders import (
    ORDERS,
    BuildWorker,
    LeaveRun,
    SendStates,
    SetClock,
    Side,
    TakeRing,
)
from followspot.errors import FollowspotError
from followspot.graph.plan_data import plan_from_data
from followspot.log.collector import LogCollector, collecting
from followspot.own_process import ignore_terminal
from followspot.plugins.registry import use_plugin_files
from followspot.worker.blas_limit import ONE_BLAS_THREAD
from followspot.worker.build import build_worker
from followspot.worker.change.hot_swap import HotSwap
from followspot.worker.change.rewiring import Rewiring
from followspot.worker.clock import Clock
from followspot.worker.edge_links import EdgeLinks, rows_of, uses_zenoh
from followspot.worker.ledger import Ledger
from followspot.worker.orders import Orders
from followspot.worker.os_scheduling import apply_scheduling
from followspot.worker.reporting.host_reporter import HostReporter
from followspot.worker.reporting.report import Warnings, missing, worker_report
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler
from followspot.worker.taps.worker_taps import WorkerTaps
from followspot.worker.wiring import RunOptions, Wiring

if TYPE_CHECKING:
    from followspot.worker.taps.published_ports import PublishedPort

_REMINDER = 0.5
"""Seconds between two announcements, at the barrier, that the ends of edges here exist."""


class WorkerMain:
    """The life of one worker.

    in_process: True for a worker that is a thread of its host's process: it installs no signal handlers and
    never ends the process.
    """

    def __init__(self, channel: Channel, *, in_process: bool = False) -> None:
        self.channel = channel
        self._in_process = in_process
        self.log = LogCollector("")
        self.warnings = Warnings(lambda stage, text: self.log.say("warning", stage, text))
        self.scheduler: Scheduler | None = None
        self.links: EdgeLinks | None = None
        self.taps: WorkerTaps | None = None
        self.restart = False
        self.reporter = HostReporter(channel, self.log, self.warnings)
        self.published: list[PublishedPort] = []
        self._early: list[Received] = []
        """Orders that came before the start."""

    def live(self) -> None:
        """Build, start, run, report. Raises ChannelClosed when the host ends before the start."""
        rings: dict[Side, dict[int, socket.socket]] = {"sending": {}, "receiving": {}}
        order, descriptors = self.channel.receive()
        while isinstance(order, TakeRing):
            rings[order.side][order.edge] = socket.socket(fileno=descriptors[0])
            order, descriptors = self.channel.receive()
        assert isinstance(order, BuildWorker)
        name, error, self.restart = order.worker, "", order.restart
        self.log.worker = name
        try:
            self.links = links = self._links(order, rings["sending"], rings["receiving"])
            self.scheduler = self._build(order, descriptors[0], links)
            self.taps = WorkerTaps(name, self.scheduler, links, partial(self.warnings.add, "taps"))
            self._give_up(order.over)
            self.channel.send(Built())
            if not order.incarnation:  # a restarted worker finds the others running, or some of them gone
                links.wait_matched(lambda: not self._stopped_early())
            if not self._stopped_early():
                self._get_ready(order, self.scheduler)
                if self._started():
                    self._run()
        except FollowspotError as failure:
            error = str(failure)
        finally:
            self.reporter.stop()
            if self.taps is not None:
                self.taps.close()
            if self.scheduler is not None:
                self.scheduler.close()
            if self.links is not None:
                self.links.close()
        for edge, times in self.links.rejected().items() if self.links is not None else ():
            self.warnings.add(edge, f"refused {times} times what was malformed or not from its sender")
        self.reporter.send_log()
        if self.scheduler is not None:
            self.reporter.send_stages(self.scheduler)
            if not (error or self.restart or self.links is None or self.links.plan.live):
                error = missing(self.scheduler)
            self.channel.send(Done(report=worker_report(name, self.scheduler, self.warnings, error)))
        else:
            self.channel.send(Failed(error=error))

    def _links(
        self,
        order: BuildWorker,
        sending: dict[int, socket.socket],
        receiving: dict[int, socket.socket],
    ) -> EdgeLinks:
        """Open the Zenoh session, if needed, and take the ends of the rings over."""
        plan = plan_from_data(order.plan)
        for refusal in apply_scheduling(plan.scheduling_of(order.worker)):  # before any thread is started
            self.warnings.add(f"worker {order.worker}", refusal)
        session = None
        network = order.network
        if uses_zenoh(plan, order.worker) or network.leads_somewhere:
            from followspot.transport.zenoh.session import connected, locators, log_rejections

            if network.certificates:  # the host counts the rejected peers that Zenoh logs
                log_rejections()
            session = connected(network)
            self.channel.send(Listening(locators=tuple(locators(session))))
        return EdgeLinks(plan, sending, receiving, session, order.run, order.incarnation)

    def _build(self, order: BuildWorker, memory: int, links: EdgeLinks) -> Scheduler:
        """Build the stages. memory: file descriptor of the ledger's memory."""
        use_plugin_files(links.plan.plugin_files)
        self.ledger = Ledger(links.plan.rows, _shared_words(memory))
        self.clock = Clock(*order.clock)
        self.options = options = RunOptions(
            Path(order.out),
            order.frames,
            self.warnings.add,
            order.restart,
            self.clock,
            resumed=order.incarnation > 0,
        )
        return build_worker(Wiring(links.plan), order.worker, self.ledger, options, links)

    def _stopped_early(self) -> bool:
        """Whether the run is stopped before this worker is ready; other ends may be gone by then."""
        while self.channel.waits(0.0):
            self._early.append(self.channel.receive())
        return any(isinstance(received.request, StopRun) for received in self._early)

    def _get_ready(self, order: BuildWorker, scheduler: Scheduler) -> None:
        """Set all stages up, and tell the host."""
        scheduler.setup()
        self._restore(order.states)
        self.reporter.send_log()
        sources = scheduler.sources
        last_times = sources.last_times() if order.frames is not None else {}
        self.channel.send(Ready(expected=sources.expected(), last_times=last_times))

    def _started(self) -> bool:
        """Wait at the barrier for the start; False if the run is stopped before."""
        assert self.links is not None
        while True:
            while not self.channel.waits(_REMINDER):
                self.links.remind()
            received = self.channel.receive()
            if isinstance(received.request, StartRun):
                self.clock.begun = received.request.begun
            if isinstance(received.request, StartRun | StopRun):
                return isinstance(received.request, StartRun)
            self._early.append(received)

    def _run(self) -> None:
        """Run the stages to the end of all streams, and obey the orders of the host meanwhile."""
        assert self.scheduler is not None
        assert self.links is not None
        if self.links.session is not None:
            from followspot.worker.taps.published_ports import published

            self.published = published(self.links, self.scheduler)
        answer = self.reporter.send_change
        self.change = HotSwap(self.scheduler, answer, self._rewiring)
        handlers = self._handlers(self.scheduler, self.links)
        orders = Orders(
            self.channel, self.scheduler, handlers, in_process=self._in_process, restart=self.restart
        )
        orders.listen(self._early)
        if not self._in_process:
            signal.signal(signal.SIGTERM, lambda *_: self.scheduler.stop() if self.scheduler else None)
        self.reporter.start(self.scheduler, orders.leave_soon)
        try:
            self.scheduler.run()
        finally:
            self.change.close()

    def _handlers(self, scheduler: Scheduler, links: EdgeLinks) -> Handlers:
        """The handlers of all orders to a running worker."""
        return {
            **scheduler.handlers,
            **(self.taps.handlers if self.taps is not None else {}),
            EndWorkers: lambda order: self._give_up(order.workers),
            TakeRing: lambda order, end: links.take(scheduler, order, socket.socket(fileno=end)),
            SendStates: lambda _: self.reporter.send_states(scheduler),
            SetClock: self._set_clock,
            LeaveRun: self._leave_run,
            ChangeOrder: self.change.obey,
        }

    def _rewiring(self, data: dict[str, Any]) -> Rewiring:
        """What a new plan adds to the worker. Raises FollowspotError."""
        assert self.scheduler is not None
        assert self.links is not None
        name, links = self.log.worker, self.links.for_plan(plan_from_data(data))
        rewired = partial(self._rewired, links)
        return Rewiring(self.scheduler, Wiring(links.plan), name, self.ledger, self.options, links, rewired)

    def _rewired(self, links: EdgeLinks, new: Sequence[StageRunner]) -> None:
        """Have the plan of these links from now on. new: stages that it adds here."""
        assert self.scheduler is not None
        assert self.links is not None
        self.links.adopt(links)
        for runner in new:
            self.warnings.begin(runner.name)
        if self.links.session is not None:
            from followspot.worker.taps.published_ports import published

            self.published += published(self.links, self.scheduler, self.published)

    def _set_clock(self, order: SetClock) -> None:
        self.clock.captured, self.clock.steady = order.correction

    def _leave_run(self, _: LeaveRun) -> None:
        """Send checkpoints and end the worker in the middle of its streams. Raises ChannelClosed."""
        assert self.scheduler is not None
        self.reporter.send_states(self.scheduler)
        raise ChannelClosed("this worker's stages move to another worker")

    def _give_up(self, workers: Collection[str]) -> None:
        """These workers have ended: nothing more comes from the other ends of their edges."""
        assert self.scheduler is not None
        assert self.links is not None
        self.scheduler.ends.give_up(rows_of(self.links.plan, workers))

    def _restore(self, states: dict[str, Any]) -> None:
        """Restore the checkpoints of the stages of the worker that died."""
        assert self.scheduler is not None
        for runner in self.scheduler.runners:
            if runner.name in states:
                try:
                    runner.stage.restore(state_from_data(states[runner.name]))
                except Exception as error:
                    self.warnings.add(
                        runner.name, f"it starts without its former state, which cannot be restored: {error}"
                    )


def _shared_words(fd: int) -> memoryview:
    """All rows of the ledger: also those for edges that the graph may yet get."""
    import mmap

    return memoryview(mmap.mmap(fd, 0)).cast("q")


def run_worker(descriptor: int) -> int:
    """Be a worker, and return the exit code of its process. descriptor: of its control channel."""
    ignore_terminal()  # the host decides when the worker ends
    channel = Channel(socket.socket(fileno=descriptor), ORDERS)
    worker = WorkerMain(channel)
    try:
        with collecting(worker.log), ONE_BLAS_THREAD:
            worker.live()
    except ChannelClosed:
        return 1
    except Exception:
        worker.reporter.send_crash()
        raise
    return 0


if __name__ == "__main__":
    sys.exit(run_worker(int(sys.argv[1])))
