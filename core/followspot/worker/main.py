"""A worker process: `python -m followspot.worker.main FD`, where FD is its control channel.

The host sends the plan; the worker builds its stages, says that it is ready, waits for the start, runs,
and reports. When the host dies, the worker ends its sources, completes its outputs and exits.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
import time
import traceback
from collections.abc import Collection, Sequence
from contextlib import suppress
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from followspot.control.checkpoint import state_from_data, state_to_data
from followspot.control.dispatch import Dispatcher
from followspot.control.lifecycle import EndWorkers, StartRun, StopRun
from followspot.control.pipe import Channel, ChannelClosed, Received
from followspot.control.swap import ChangeOrder, ChangeStatus
from followspot.control.worker_messages import (
    Built,
    Change,
    Done,
    Failed,
    Listening,
    Log,
    Progress,
    Ready,
    Stages,
    State,
)
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
from followspot.graph.ship import plan_from_data
from followspot.log.collector import LogCollector, collecting
from followspot.plugins.registry import use_plugin_files
from followspot.worker.build import build_worker
from followspot.worker.clock import Clock
from followspot.worker.edge_links import EdgeLinks, rows_of, uses_zenoh
from followspot.worker.hot_swap import HotSwap
from followspot.worker.ledger import COLUMNS, Ledger
from followspot.worker.report import Warnings, missing, worker_report
from followspot.worker.scheduler import Worker
from followspot.worker.stage_status import Idleness, paths_now, stages_now
from followspot.worker.taps import WorkerTaps
from followspot.worker.wiring import RunOptions, Wiring

_PROGRESS_PERIOD = 0.2
"""Seconds between two reports of progress."""
_STAGES_EVERY = 3
"""Reports of progress from one picture of all stages to the next."""
_REMINDER = 0.5
"""Seconds, at the barrier, between two words to other workers that the ends of edges here are there."""
GRACE = 3.0
"""Seconds that a worker has to complete its outputs when its agent is gone."""


class WorkerMain:
    """The life of one worker.

    in_process: whether it is a thread of its host's process, which it leaves alone.
    """

    def __init__(self, channel: Channel, *, in_process: bool = False) -> None:
        self.channel = channel
        self._in_process = in_process
        self.log = LogCollector("")
        self.warnings = Warnings(lambda stage, text: self.log.say("warning", stage, text))
        self.worker: Worker | None = None
        self.links: EdgeLinks | None = None
        self.taps: WorkerTaps | None = None
        self.idleness = Idleness()
        self.restart = False
        self.over = threading.Event()
        self._orders: list[Received] = []
        """Orders that came before the start."""
        self._telling = threading.Lock()

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
            self.worker = self._build(order, descriptors[0], links)
            self.taps = WorkerTaps(name, self.worker, links, partial(self.warnings.add, "taps"))
            self._give_up(order.over)
            self.channel.send(Built())
            if not order.incarnation:  # later ones find the others at work, and some perhaps not at all
                links.wait_matched()
            self.worker.setup()
            self._restore(order.states)
            self._tell_log()
            self.channel.send(Ready(expected=self.worker.expected()))
            if self._started():
                self._run()
        except FollowspotError as failure:
            error = str(failure)
        finally:
            self.over.set()
            if self.taps is not None:
                self.taps.close()
            if self.worker is not None:
                self.worker.close()
            if self.links is not None:
                self.links.close()
        for edge, times in self.links.strangers().items() if self.links is not None else ():
            self.warnings.add(edge, f"refused {times} times what was malformed or not from its sender")
        self._tell_log()
        if self.worker is not None:
            self._tell_stages(self.worker)
            if not (error or self.restart or self.links is None or self.links.plan.live):
                error = missing(self.worker)
            self.channel.send(Done(report=worker_report(name, self.worker, self.warnings, error)))
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
        session = None
        network = order.network
        if uses_zenoh(plan, order.worker) or network.leads_somewhere:
            from followspot.transport.zenoh.session import connected, locators, log_refusals

            if network.certificates:  # whoever started this process counts them
                log_refusals()
            session = connected(network)
            self.channel.send(Listening(locators=tuple(locators(session))))
        return EdgeLinks(plan, sending, receiving, session, order.run, order.incarnation)

    def _build(self, order: BuildWorker, memory: int, links: EdgeLinks) -> Worker:
        """Build the stages. memory: descriptor of that of the ledger."""
        use_plugin_files(links.plan.plugin_files)
        edges = len(links.plan.edges)
        ledger = Ledger(edges, _shared_words(memory, edges))
        self.clock = Clock(*order.clock)
        options = RunOptions(Path(order.out), order.frames, self.warnings.add, order.restart, self.clock)
        return build_worker(Wiring(links.plan), order.worker, ledger, options, links)

    def _started(self) -> bool:
        """Wait at the barrier; False where the run is called off."""
        assert self.links is not None
        while True:
            while not self.channel.waits(_REMINDER):
                self.links.remind()
            received = self.channel.receive()
            if isinstance(received.request, StartRun | StopRun):
                return isinstance(received.request, StartRun)
            self._orders.append(received)

    def _run(self) -> None:
        assert self.worker is not None
        assert self.links is not None
        if self.links.session is not None:
            from followspot.worker.published_ports import published

            self.published = published(self.worker, self.links)
        self.change = HotSwap(self.worker, self._tell_change)
        self._dispatcher = self._handlers(self.worker, self.links)
        self.worker.watch(self.channel.fileno(), self._listen)
        self.worker.pace.watch(self.channel.fileno(), self._listen)
        self._obey([*self._orders, *self.channel.buffered()])
        if not self._in_process:
            signal.signal(signal.SIGTERM, lambda *_: self.worker.stop() if self.worker else None)
        threading.Thread(target=self._tell_progress, name="progress", daemon=True).start()
        try:
            self.worker.run()
        finally:
            self.change.close()

    def _listen(self) -> bool:
        """Something came from the host, or it is gone: a stop at once, all else between two firings."""
        assert self.worker is not None
        try:
            received = self.channel.arrived()
        except ChannelClosed:
            self._leave_soon()
            if self.restart:  # another one will take its place, so its streams are not over
                self.worker.between_firings(_leave)
            self.worker.stop()
            return True
        if any(isinstance(order, StopRun) for order, _ in received):
            self.worker.stop()
        self.worker.between_firings(partial(self._obey, received))
        return False

    def _obey(self, received: Sequence[Received]) -> None:
        """Orders to a running worker come between two firings."""
        for order, descriptors in received:
            self._dispatcher.dispatch(order, *descriptors)

    def _handlers(self, worker: Worker, links: EdgeLinks) -> Dispatcher:
        """What the host may order while the worker runs."""
        return Dispatcher(
            "worker",
            {
                **worker.handlers,
                **(self.taps.handlers if self.taps is not None else {}),
                EndWorkers: lambda order: self._give_up(order.workers),
                TakeRing: lambda order, end: links.renew(worker, order.edge, socket.socket(fileno=end)),
                SendStates: lambda _: self._tell_states(),
                SetClock: self._set_clock,
                LeaveRun: self._leave_run,
                ChangeOrder: self.change.obey,
            },
        )

    def _set_clock(self, order: SetClock) -> None:
        self.clock.captured, self.clock.steady = order.correction

    def _leave_run(self, _: LeaveRun) -> None:
        """Raises ChannelClosed."""
        self._tell_states()
        raise ChannelClosed("this worker's stages go elsewhere")

    def _give_up(self, workers: Collection[str]) -> None:
        """These workers have ended: nothing more comes from the other ends of their edges."""
        assert self.worker is not None
        assert self.links is not None
        self.worker.give_up(rows_of(self.links.plan, workers))

    def _tell_change(self, status: ChangeStatus) -> None:
        with suppress(ChannelClosed):  # it is noticed where orders are read
            self.channel.send(Change(status=status))

    def _tell_states(self) -> None:
        """What successors of the stages would need to carry on."""
        assert self.worker is not None
        for runner in self.worker.runners:
            try:
                state = state_to_data(runner.stage.state())
            except Exception as error:
                self.warnings.add(runner.name, f"its state cannot be kept: {error}")
                continue
            if state is not None:
                self.channel.send(State(stage=runner.name, state=state))

    def _restore(self, states: dict[str, Any]) -> None:
        """Carry on from what the stages of the worker that died had told."""
        assert self.worker is not None
        for runner in self.worker.runners:
            if runner.name in states:
                try:
                    runner.stage.restore(state_from_data(states[runner.name]))
                except Exception as error:
                    self.warnings.add(
                        runner.name, f"it starts anew, for its state cannot be restored: {error}"
                    )

    def _tell_progress(self) -> None:
        assert self.worker is not None
        for turn in count():
            if self.over.wait(_PROGRESS_PERIOD):
                return
            progress = self.worker.progress()
            try:
                self.channel.send(Progress(fired=progress.fired, time=progress.time))
                self._tell_log()
                if turn % _STAGES_EVERY == 0:
                    self._tell_stages(self.worker)
            except ChannelClosed:
                self._leave_soon()
                return

    def _leave_soon(self) -> None:
        """The agent is gone: outputs are completed within the grace, or not at all."""
        if not self._in_process:
            threading.Thread(target=_exit_later, daemon=True).start()

    def tell_crash(self) -> None:
        """The exception that is being handled ends the worker: its traceback is its last word."""
        with suppress(ChannelClosed):
            self.log.say("error", "", f"the worker breaks down\n{traceback.format_exc()}")
            self._tell_log()

    def _tell_log(self) -> None:
        """From any thread; on return, what another thread has taken is told, too: "done" comes after all."""
        with self._telling:
            if records := self.log.take():
                self.channel.send(Log(records=tuple(records)))

    def _tell_stages(self, worker: Worker) -> None:
        stages = tuple(self.idleness.noted(stages_now(worker, self.warnings.last)))
        self.channel.send(Stages(stages=stages, paths=paths_now(worker)))


def _leave() -> None:
    """End the worker in the middle of its streams. Raises ChannelClosed."""
    raise ChannelClosed("the agent is gone")


def _exit_later() -> None:
    """The agent is gone: leave the worker its grace, then end the process whatever it does."""
    time.sleep(GRACE)
    os._exit(1)


def _shared_words(fd: int, edges: int) -> memoryview:
    import mmap

    return memoryview(mmap.mmap(fd, max(1, edges) * COLUMNS * 8)).cast("q")


def main() -> int:
    """Entry of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal sends Ctrl-C to all; the agent decides
    channel = Channel(socket.socket(fileno=int(sys.argv[1])), ORDERS)
    main = WorkerMain(channel)
    try:
        with collecting(main.log):
            main.live()
    except ChannelClosed:
        return 1
    except Exception:
        main.tell_crash()
        raise
    return 0


if __name__ == "__main__":
    sys.exit(main())
