"""A worker process: `python -m followspot.worker.main FD`, where FD is its control channel.

The host sends the plan; the worker builds its stages, says that it is ready, waits for the start, runs,
and reports. When the host dies, the worker ends its sources, completes its outputs and exits.
"""

from __future__ import annotations

import signal
import socket
import sys
import threading
from pathlib import Path

from followspot.control.lifecycle import StartRun, StopRun
from followspot.control.pipe import Channel, ChannelClosed, Received
from followspot.control.worker_messages import Built, Done, Failed, Listening, Ready
from followspot.control.worker_orders import ORDERS, BuildWorker, Side, TakeRing
from followspot.errors import FollowspotError
from followspot.graph.plan_data import plan_from_data
from followspot.log.collector import LogCollector, collecting
from followspot.operating_system.child_processes import ignore_terminal
from followspot.plugins.registry import use_plugin_files
from followspot.worker.blas_limit import ONE_BLAS_THREAD
from followspot.worker.build import build_worker
from followspot.worker.built_worker import BuiltWorker
from followspot.worker.clock import Clock
from followspot.worker.ledger import Ledger
from followspot.worker.orders import Orders
from followspot.worker.os_scheduling import apply_scheduling
from followspot.worker.process_end import STAGES_CANNOT_EXIT, end_process
from followspot.worker.reporting.host_reporter import HostReporter
from followspot.worker.reporting.late_threads import late_threads
from followspot.worker.reporting.rejections import Rejections
from followspot.worker.reporting.report import Warnings, missing, worker_report
from followspot.worker.runners.shared_state import begin_with_default_errors
from followspot.worker.wiring import RunOptions, Wiring
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

_REMINDER = 0.5
"""Seconds between two announcements, at the barrier, that the ends of edges here exist."""
_Rings = dict[Side, dict[int, socket.socket]]
"""This worker's ends of rings, by side and number of the edge."""


class WorkerMain:
    """The life of one worker.

    in_process: True for a worker that is a thread of its host's process: it installs no signal handlers and
    never ends the process.
    """

    def __init__(self, channel: Channel, *, in_process: bool = False) -> None:
        self.channel = channel
        self._in_process = in_process
        self._threads_before = frozenset(threading.enumerate())
        self.log = LogCollector("")
        self.warnings = Warnings(lambda stage, text: self.log.say("warning", stage, text))
        self.reporter = HostReporter(channel, self.log, self.warnings)
        self.has_late_threads = False
        """Whether threads of stages go on, which would hold up the end of a process."""
        self.worker: BuiltWorker | None = None
        """The stages, once they are built."""
        self._rejections: Rejections | None = None
        self._early: list[Received] = []
        """Orders that came before the start."""

    def live(self) -> None:
        """Build, start, run, report. Raises ChannelClosed when the host ends before the start."""
        order, memory, rings = self._receive_plan()
        self.log.worker = order.worker
        edge_factory: WorkerEdgeFactory | None = None
        error = ""
        try:
            edge_factory = self._edge_factory(order, rings)
            self._rejections = Rejections(edge_factory, self.log, certified=bool(order.network.certificates))
            self.worker = worker = self._build(order, memory, edge_factory)
            if self._get_ready(order, worker) and self._started(worker):
                self._run(worker, self._rejections, restart=order.restart)
        except FollowspotError as failure:
            error = str(failure)
        finally:
            if self.worker is not None:
                self.worker.close()
                self._await_threads(self.worker)
            self.reporter.stop()  # until now the host hears of this worker
            if edge_factory is not None:
                edge_factory.zenoh.close()
        if self._rejections is not None:
            self._rejections.warn(self.warnings)
        self.reporter.send_log()
        if self.worker is None:
            self.channel.send(Failed(error=error))
        else:
            self._report(self.worker, error, restart=order.restart)

    def _receive_plan(self) -> tuple[BuildWorker, memoryview, _Rings]:
        """The order to build, the memory of the ledger, and the ends of rings that come before.

        Raises ChannelClosed.
        """
        rings: _Rings = {"sending": {}, "receiving": {}}
        order, descriptors = self.channel.receive()
        while isinstance(order, TakeRing):
            rings[order.side][order.edge] = socket.socket(fileno=descriptors[0])
            order, descriptors = self.channel.receive()
        assert isinstance(order, BuildWorker)
        return order, _shared_words(descriptors[0]), rings

    def _edge_factory(self, order: BuildWorker, rings: _Rings) -> WorkerEdgeFactory:
        """Open the Zenoh session, if needed, and take the ends of the rings over."""
        plan = plan_from_data(order.plan)
        for refusal in apply_scheduling(plan.scheduling_of(order.worker)):  # before any thread is started
            self.warnings.add(f"worker {order.worker}", refusal)
        session = None
        network = order.network
        if plan.uses_zenoh(order.worker) or network.leads_somewhere:
            from followspot.transport.zenoh.session import connected_in_the_end, locators, log_rejections

            if network.certificates:  # the host counts the rejected peers that Zenoh logs
                log_rejections()
            session = connected_in_the_end(network, self._warn_now, lambda: not self._stopped_early())
            self.channel.send(Listening(locators=tuple(locators(session))))
        return WorkerEdgeFactory(
            plan, rings["sending"], rings["receiving"], session, order.run, order.incarnation
        )

    def _warn_now(self, text: str) -> None:
        """Warn while the worker is not built yet, and nothing else sends its log."""
        self.warnings.add(f"worker {self.log.worker}", text)
        self.reporter.send_log()

    def _build(self, order: BuildWorker, memory: memoryview, edge_factory: WorkerEdgeFactory) -> BuiltWorker:
        """Build the stages. memory: of the ledger."""
        use_plugin_files(edge_factory.plan.plugin_files)
        ledger = Ledger(edge_factory.plan.rows, memory)
        options = RunOptions(
            Path(order.out),
            order.frames,
            self.warnings.add,
            order.restart,
            Clock(*order.clock),
            resumed=order.incarnation > 0,
        )
        scheduler = build_worker(Wiring(edge_factory.plan), order.worker, ledger, options, edge_factory)
        begin_with_default_errors()
        return BuiltWorker(
            order.worker, scheduler, edge_factory, ledger, options, self.reporter, self.warnings
        )

    def _get_ready(self, order: BuildWorker, worker: BuiltWorker) -> bool:
        """Connect all edges, set all stages up, and tell the host; False if the run is stopped before."""
        worker.give_up(order.over)
        self.channel.send(Built())
        if not order.incarnation:  # a restarted worker finds the others running, or some of them gone
            worker.edge_factory.wait_matched(lambda: not self._stopped_early())
        if self._stopped_early():
            return False
        worker.scheduler.setup()
        worker.restore(order.states)
        self.reporter.send_log()
        sources = worker.scheduler.sources
        last_times = sources.last_times() if order.frames is not None else {}
        self.channel.send(Ready(expected=sources.expected(), last_times=last_times))
        return True

    def _stopped_early(self) -> bool:
        """Whether the run is stopped before this worker is ready; other ends may be gone by then."""
        while self.channel.waits(0.0):
            self._early.append(self.channel.receive())
        return any(isinstance(received.request, StopRun) for received in self._early)

    def _started(self, worker: BuiltWorker) -> bool:
        """Wait at the barrier for the start; False if the run is stopped before."""
        while True:
            while not self.channel.waits(_REMINDER):
                worker.edge_factory.zenoh.announce_again()
            received = self.channel.receive()
            if isinstance(received.request, StartRun):
                worker.options.clock.begun = received.request.begun
            if isinstance(received.request, StartRun | StopRun):
                return isinstance(received.request, StartRun)
            self._early.append(received)

    def _run(self, worker: BuiltWorker, rejections: Rejections, *, restart: bool) -> None:
        """Run the stages to the end of all streams, and obey the orders of the host meanwhile."""
        worker.publish_ports()
        scheduler = worker.scheduler
        orders = Orders(
            self.channel, scheduler, worker.handlers, in_process=self._in_process, restart=restart
        )
        orders.listen(self._early)
        if not self._in_process:
            signal.signal(signal.SIGTERM, lambda *_: scheduler.stop())
        self.reporter.start(scheduler, orders.leave_soon, rejections.tell_new)
        worker.run()

    def _await_threads(self, worker: BuiltWorker) -> None:
        """Wait some seconds for threads that stages have left, and warn of those that go on."""
        stages = [(runner.name, runner.stage) for runner in worker.scheduler.runners]
        late = late_threads(self._threads_before, stages, own_process=not self._in_process)
        for stage, text in late:
            self.warnings.add(stage or f"worker {worker.name}", text)
            self.has_late_threads = True

    def _report(self, worker: BuiltWorker, error: str, *, restart: bool) -> None:
        """Send the last status and the report of a worker that has ended. Raises ChannelClosed."""
        scheduler = worker.scheduler
        self.reporter.send_stages(scheduler)
        if not (error or restart or worker.edge_factory.plan.live):
            error = missing(scheduler)
        self.channel.send(Done(report=worker_report(worker.name, scheduler, self.warnings, error)))


def _shared_words(fd: int) -> memoryview:
    """All rows of the ledger: also those for edges that the graph may yet get. Closes the descriptor."""
    import mmap

    with open(fd, "rb"):  # a worker may be a thread of a script, which makes many runs
        return memoryview(mmap.mmap(fd, 0)).cast("q")


def run_worker(descriptor: int) -> int:
    """Be a worker, and return the exit code of its process. descriptor: of its control channel."""
    ignore_terminal()  # the host decides when the worker ends
    channel = Channel(socket.socket(fileno=descriptor), ORDERS)
    worker = WorkerMain(channel)
    code = 0
    try:
        with collecting(worker.log), ONE_BLAS_THREAD, STAGES_CANNOT_EXIT:
            worker.live()
    except ChannelClosed:  # the host has ended, and ends no worker any more
        code = 1
    except Exception:
        worker.reporter.send_crash()
        raise
    if worker.has_late_threads:  # the host would wait, and hear no other worker or operator meanwhile
        sys.stdout.flush()
        sys.stderr.flush()
        end_process(code)
    return code


if __name__ == "__main__":
    sys.exit(run_worker(int(sys.argv[1])))
