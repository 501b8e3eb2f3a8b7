"""A run on this host: its worker pool and supervisor, the host's clock, the memory of the ledger."""

from __future__ import annotations

import mmap
import os
import time
from collections import deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from followspot.control.clock_status import ClockWarnings
from followspot.control.dispatch import Dispatcher, RunRequest
from followspot.control.host import HostStatus, RunOrder
from followspot.control.lifecycle import EndWorkers, StartRun, StopRun
from followspot.control.move import MoveOrder
from followspot.control.observation import GetHostStatus, GetLog, GetStates
from followspot.control.swap import ChangeOrder, ChangeStatus
from followspot.control.worker_orders import RELAYED, SetClock
from followspot.errors import FollowspotError
from followspot.graph.plan import MAX_NEW_EDGES, Plan
from followspot.graph.plan_data import plan_from_data
from followspot.host.checkpoint_file import CheckpointFile
from followspot.host.clocks.host import HostClock, reference
from followspot.host.hot_swap import HostSwaps
from followspot.host.ledger_file import ledger_memory
from followspot.host.supervisor import Supervisor
from followspot.host.worker_pool import WorkerPool
from followspot.host.worker_process import WorkerProcess
from followspot.log.record import Level
from followspot.log.run_log import RunLog
from followspot.transport.zenoh.network import Network
from followspot.worker.ledger import COLUMNS, Ledger

_MAX_NEWS = 200
"""Most lines of news that are kept."""


class LocalHost:
    """`Host` whose workers are child processes or threads of this process.

    name: of the host, "" for the operator's own; network: for the Zenoh sessions of workers; hub: locators of
    a session that all workers connect to, empty if each worker connects to those started before it.
    """

    pool: WorkerPool
    """The workers; from `prepare` on."""
    supervisor: Supervisor
    ask: Callable[[RunRequest], Any]
    """Hands a request to its handler, in this process; from `prepare` on."""

    def __init__(
        self,
        name: str,
        network: Network = Network(),
        hub: Sequence[str] = (),
        clock: HostClock | None = None,
        in_process: Collection[str] = (),
    ) -> None:
        """clock: compares this host's clock with the reference; in_process: workers that are threads here."""
        self.name = name
        self.network = network
        self.hub = tuple(hub)
        self.clock = HostClock() if clock is None else clock
        self._in_process = in_process
        self._memory: int | None = None
        """Descriptor of the ledger's memory."""
        self.ledger = Ledger(0)
        self.out = ""
        self.log = RunLog()
        self.news: list[str] = []
        self._moves: deque[MoveOrder] = deque()
        self._swaps: HostSwaps | None = None
        self._checkpoints: CheckpointFile | None = None
        """None if the run dies with this process."""
        self._clock_warnings = ClockWarnings()

    @property
    def workers(self) -> dict[str, WorkerProcess]:
        """By name; none before the run is prepared."""
        return self.pool.workers if hasattr(self, "pool") else {}

    @property
    def order(self) -> RunOrder:
        """The order that was prepared."""
        return self.pool.order

    @property
    def plan(self) -> Plan:
        """The plan after all changes and moves."""
        return self.pool.plan

    def prepare(self, order: RunOrder, ledger: Path | None = None) -> None:
        """Start all workers that have not ended; they wait for `start`. Raises FollowspotError, OSError.

        ledger: file that keeps the counts if this process dies, and beside it the checkpoints of stages; None
        if the run dies with it.
        """
        self.out = str(Path(order.out or ".").resolve())
        plan = plan_from_data(order.plan)
        edges = plan.rows + MAX_NEW_EDGES
        size = edges * COLUMNS * 8
        memory = self._memory = ledger_memory(ledger, size)
        self.ledger = Ledger(edges, memoryview(mmap.mmap(memory, size)).cast("q"))
        order = replace(order, out=self.out)
        self.pool = WorkerPool(self.name, order, memory, self.network, self.hub, self.log, self._in_process)
        if ledger is not None:
            self._checkpoints = CheckpointFile(ledger.with_name(".checkpoints"))
            self.pool.states.update(self._checkpoints.left(plan))
        self.supervisor = Supervisor(self.pool, self.clock, self.report_event)
        self._swaps = HostSwaps(self.pool)
        self.ask = self._dispatcher(self._swaps).dispatch
        self._follow_clock()
        self.supervisor.prepare()

    def _dispatcher(self, swaps: HostSwaps) -> Dispatcher:
        """The handlers of requests for the workers here."""
        pool, supervisor = self.pool, self.supervisor
        return Dispatcher(
            "host",
            {
                StartRun: lambda _: supervisor.start(),
                StopRun: lambda _: supervisor.stop(),
                EndWorkers: lambda request: pool.ended(request.workers),
                ChangeOrder: swaps.carry_out,
                MoveOrder: self.move,
                **dict.fromkeys(RELAYED, pool.relay),
                GetHostStatus: lambda _: self.status(),
                GetStates: lambda _: dict(pool.states),
                GetLog: lambda request: self.log.after(request.after),
            },
        )

    def move(self, order: MoveOrder) -> None:
        """One step of a move; the next `attend` does it. Raises FollowspotError."""
        if order.plan is not None:
            self.pool.check_rows(order.plan)
        if order.plan is not None and self.supervisor.move_given_up and not (order.trial or order.back):
            raise FollowspotError("the move took too long: the workers are at their old places again")
        if not order.trial:
            self._moves.append(order)

    def attend(self, timeout: float) -> None:
        """Read messages of workers for up to `timeout`, s; restart dead workers and kill hanging ones."""
        assert self._swaps is not None
        self._swaps.attend(self.pool.receive(timeout))
        self.supervisor.check(time.monotonic())
        self._swaps.attend_deaths()
        while self._moves and (self._moves[0].plan is None or self.supervisor.all_left()):
            self.supervisor.rearrange(self._moves.popleft())
            self._follow_clock()
        self._attend_clock()
        if self._checkpoints is not None:
            self._checkpoints.keep(self.pool.states, self.plan, time.monotonic())

    def status(self) -> HostStatus:
        """The newest status. Safe from any thread."""
        return HostStatus(
            workers=tuple(worker.status() for worker in tuple(self.workers.values())),
            counts=tuple(self._counts()),
            news=tuple(self.news),
            out=self.out,
            change=ChangeStatus() if self._swaps is None else self._swaps.status(),
            clock=self.clock.status(),
            logged=self.log.last,
            age_s=0.0,
        )

    def _counts(self) -> list[int]:
        """The rows of the ledger that the plan uses; none before the run is prepared."""
        rows = self.plan.rows if hasattr(self, "pool") else 0
        return self.ledger.words[: rows * COLUMNS].tolist()

    def fileno(self) -> int:
        """Descriptor that is readable when a worker has sent a message."""
        return self.pool.fileno()

    def close(self) -> bool:
        """End all workers and free the ledger's memory."""
        self.clock.close()
        if hasattr(self, "pool"):
            self.pool.close()
        if self._memory is not None:
            os.close(self._memory)
            self._memory = None
        return True

    def _follow_clock(self) -> None:
        """Follow the reference clock of the run, which may have joined with a move."""
        if (host := self.order.reference or reference(self.plan)) not in ("", self.name):
            self.clock.follow(host, self.order.run)

    def _attend_clock(self) -> None:
        """Send a new clock correction to the workers; warn the user of a large offset."""
        if (correction := self.clock.news()) is not None:
            self.pool.send_to_all(SetClock(correction=correction))
        if (step := self.clock.step_news()) is not None:
            line = f"the clock of this host was set by {step / 1e6:+.1f} ms since the run began"
            self.report_event("warning", f"{line}; the times of the run go on as before")
        if warning := self._clock_warnings.news(self.clock.status()):
            self.report_event("warning", warning)

    def report_event(self, level: Level, line: str, worker: str = "") -> None:
        """Log a line; it becomes news unless it is an error."""
        self.log.say(level, line, worker=worker)
        if level != "error":  # the reports of workers contain the errors
            self.news.append(line)
            del self.news[:-_MAX_NEWS]
