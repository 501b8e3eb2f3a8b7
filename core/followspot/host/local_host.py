"""A host's part of a run: its workers and who looks after them, its clock, the memory of the ledger."""

from __future__ import annotations

import mmap
import os
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from followspot.control.clock_status import ClockWarnings
from followspot.control.host import HostStatus, RunOrder
from followspot.control.move import MoveOrder
from followspot.control.relay import Relayed
from followspot.control.swap import ChangeOrder, ChangeStatus
from followspot.control.worker_orders import SetClock
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data
from followspot.host.clocks.host import HostClock, reference
from followspot.host.hot_swap import HostChange
from followspot.host.ledger_file import ledger_memory
from followspot.host.supervisor import Supervisor
from followspot.host.worker_pool import WorkerPool
from followspot.host.worker_process import Start, WorkerProcess, start_process
from followspot.log.record import Level
from followspot.log.run_log import RunLog
from followspot.transport.zenoh.network import Network
from followspot.worker.ledger import COLUMNS, Ledger

_MAX_NEWS = 200
"""Lines of news kept."""


class LocalHost:
    """`Host` whose workers are children of this process.

    name: of the host, "" for the operator's own; network: for the Zenoh sessions of workers;
    hub: locators of a session that brings them together, empty where they find each other in turn.
    """

    pool: WorkerPool
    """The workers; from `prepare` on."""
    supervisor: Supervisor

    def __init__(
        self,
        name: str,
        network: Network = Network(),
        hub: Sequence[str] = (),
        clock: HostClock | None = None,
        start: Start = start_process,
    ) -> None:
        """clock: of this host, compared with that of others where there are any; start: of a worker."""
        self.name = name
        self.network = network
        self.hub = tuple(hub)
        self.clock = HostClock() if clock is None else clock
        self._start = start
        self._memory: int | None = None
        """Descriptor of the ledger's memory."""
        self.ledger = Ledger(0)
        self.out = ""
        self.log = RunLog()
        self.news: list[str] = []
        self._moves: deque[MoveOrder] = deque()
        self._change = HostChange()
        self._clock_warnings = ClockWarnings()

    @property
    def workers(self) -> dict[str, WorkerProcess]:
        """By name; none before the run is prepared."""
        return self.pool.workers if hasattr(self, "pool") else {}

    @property
    def order(self) -> RunOrder:
        """What was to be prepared."""
        return self.pool.order

    @property
    def plan(self) -> Plan:
        """As it is now."""
        return self.pool.plan

    def prepare(self, order: RunOrder, ledger: Path | None = None) -> None:
        """Start all workers that have not come to their end before. Raises FollowspotError, OSError.

        ledger: file that keeps the counts over the death of this process; none where the run dies with it.
        """
        self.out = str(Path(order.out or ".").resolve())
        plan = plan_from_data(order.plan)
        edges = len(plan.edges)
        size = max(1, edges) * COLUMNS * 8
        memory = self._memory = ledger_memory(ledger, size)
        self.ledger = Ledger(edges, memoryview(mmap.mmap(memory, size)).cast("q"))
        order = replace(order, out=self.out)
        self.pool = WorkerPool(self.name, order, memory, self.network, self.hub, self.log, self._start)
        self.supervisor = Supervisor(self.pool, self.clock, self.tell)
        self._follow_clock()
        self.supervisor.prepare()

    def start(self) -> None:
        """Let all begin at once."""
        self.supervisor.start()

    def stop(self) -> None:
        """Ask every worker to finish what is in flight; once."""
        self.supervisor.stop()

    def ended(self, workers: Sequence[str]) -> None:
        """These workers, here or elsewhere, have come to their end: nobody need wait for them."""
        self.pool.ended(workers)

    def change(self, order: ChangeOrder) -> None:
        """One step of a change to stages of this host. Raises FollowspotError. Safe beside `attend`."""
        if self._change.in_the_way_of(order):
            raise FollowspotError("another change is under way; try again when it is done")
        change = HostChange(order, self.plan)
        if self.status().all("over"):
            raise FollowspotError("the run has ended")
        for name in change.parts:
            if self.workers[name].phase != "running":
                raise FollowspotError(f"worker {name} is {self.workers[name].phase}; try again in a moment")
        self._change = change
        for name, part in change.parts.items():
            self.workers[name].tell(part)

    def move(self, order: MoveOrder) -> None:
        """One step of a move; done when the host is attended next."""
        if not order.trial:
            self._moves.append(order)

    def states(self) -> dict[str, Any]:
        """What the stages here last told of their state."""
        return dict(self.pool.states)

    def relay(self, order: Relayed) -> None:
        """Tell the workers that are here, and those that begin later; safe from any thread."""
        self.pool.relay(order)

    def attend(self, timeout: float) -> None:
        """Hear what workers say, restart those that died, kill those that hang."""
        for name, answer in self.pool.hear(timeout):
            self._changed(name, answer)
        self.supervisor.look(time.monotonic())
        for worker in self.workers.values():
            if not worker.busy and self._change.died(worker.name):
                self.pool.change(self._change.parts[worker.name].stages)
        while self._moves:
            self.supervisor.rearrange(self._moves.popleft())
            self._follow_clock()
        self._attend_clock()

    def status(self) -> HostStatus:
        """The newest picture; safe from any thread."""
        return HostStatus(
            tuple(worker.status() for worker in tuple(self.workers.values())),
            tuple(self.ledger.words.tolist()),
            tuple(self.news),
            self.out,
            self._change.status(),
            self.clock.status(),
            self.log.last,
            age_s=0.0,
        )

    def fileno(self) -> int:
        """Readable when `attend` has something to hear."""
        return self.pool.fileno()

    def close(self) -> bool:
        """Leave no process behind."""
        self.clock.close()
        if hasattr(self, "pool"):
            self.pool.close()
        if self._memory is not None:
            os.close(self._memory)
            self._memory = None
        return True

    def _follow_clock(self) -> None:
        """Go by the clock of the reference, which may only have come with a move."""
        if (host := self.order.reference or reference(self.plan)) not in ("", self.name):
            self.clock.follow(host)

    def _attend_clock(self) -> None:
        """Tell the workers what to add to their clocks, and the user where that is much."""
        if (correction := self.clock.news()) is not None:
            self.pool.tell(SetClock(correction=correction))
        if warning := self._clock_warnings.news(self.clock.status()):
            self.tell("warning", warning)

    def _changed(self, worker: str, answer: ChangeStatus) -> None:
        """A worker's answer; who is started again from now on gets the stages that have taken over."""
        if self._change.heard(worker, answer):
            self.pool.change(self._change.parts[worker].stages)

    def tell(self, level: Level, line: str, worker: str = "") -> None:
        """Log a line; what is no error becomes news, for those stand in the reports of workers."""
        self.log.say(level, line, worker=worker)
        if level != "error":  # those stand in the reports of workers
            self.news.append(line)
            del self.news[:-_MAX_NEWS]
