"""A host's part of a run: its workers, the rings between them, the memory of the ledger."""

from __future__ import annotations

import mmap
import os
import selectors
import time
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from followspot.deploy.changes.move_order import MoveOrder
from followspot.deploy.changes.on_host import HostChange
from followspot.deploy.changes.order import ChangeOrder, ChangeStatus
from followspot.deploy.clocks.host import HostClock, reference
from followspot.deploy.host import HostStatus, RunOrder
from followspot.deploy.links import uses_zenoh
from followspot.deploy.log.record import Level, records_from_data
from followspot.deploy.log.run_log import RunLog
from followspot.deploy.report import WorkerReport
from followspot.deploy.rings import RingEnd, Rings
from followspot.deploy.supervision import BackOff, Pulse
from followspot.deploy.worker_process import WorkerProcess
from followspot.errors import FollowspotError
from followspot.graph.change import with_stages
from followspot.graph.move import host_workers
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data, plan_to_data
from followspot.runtime.ledger import COLUMNS, Ledger
from followspot.runtime.tapping import Tapping
from followspot.transport.zenoh_network import Network

_GRACE = 15.0
"""Seconds that workers have to drain after a stop before they are killed."""
_MAX_NEWS = 200
"""Lines of news kept."""
_SNAPSHOT_PERIOD = 1.0
"""Seconds between two pictures of the state of a worker's stages, where workers are restarted."""


class HostRun:
    """`Host` whose workers are children of this process.

    name: of the host, "" for the operator's own; network: for the Zenoh sessions of workers;
    hub: locators of a session that brings them together, empty where they find each other in turn.
    """

    def __init__(
        self,
        name: str,
        network: Network = Network(),
        hub: Sequence[str] = (),
        clock: HostClock | None = None,
    ) -> None:
        """clock: of this host, compared with that of others where there are any."""
        self.clock = HostClock() if clock is None else clock
        self.name = name
        self.network = network
        self.hub = tuple(hub)
        self.workers: dict[str, WorkerProcess] = {}
        self.ledger = Ledger(0)
        self.out = ""
        self.log = RunLog()
        self.news: list[str] = []
        self._selector = selectors.DefaultSelector()
        self._running = self._stopping = self._ending = False
        self._restart_at: dict[str, float] = {}
        self._states: dict[str, Any] = {}
        """What each stage last told of its state."""
        self._moves: deque[MoveOrder] = deque()
        self._left: set[str] = set()
        """Workers that have left their place, or are about to, until the run is rearranged."""
        self._snapshot_at = 0.0
        self._kill_at: float | None = None
        self._pulse = Pulse()
        self._back_off = BackOff()
        self._taps: list[dict[str, Any]] = []
        self._change = HostChange()
        self._clock_warned = False

    def prepare(self, order: RunOrder, ledger: Path | None = None) -> None:
        """Start all workers, each with its ends of the rings. Raises FollowspotError, OSError.

        ledger: file that keeps the counts over the death of this process; none where the run dies with it.
        """
        self.order = order
        self.plan: Plan = plan_from_data(order.plan)
        self._plan_data = order.plan
        self.out = str(Path(order.out or ".").resolve())
        edges = len(self.plan.edges)
        size = max(1, edges * COLUMNS * 8)
        self._ledger_fd = _memory(ledger, size)
        self.ledger = Ledger(edges, memoryview(mmap.mmap(self._ledger_fd, size)).cast("q"))
        mine = [worker.name for worker in self.plan.workers if worker.host == self.name]
        self.rings = Rings(self.plan, set(mine))
        if (host := reference(self.plan)) not in ("", self.name):
            self.clock.follow(host)
        for name in mine:
            self._spawn(name, order.incarnations.get(name, 0))

    def start(self) -> None:
        """Let all begin at once."""
        self._running = True
        for worker in self.workers.values():
            if worker.phase == "ready":  # else it begins when it is
                self._begin(worker)

    def stop(self) -> None:
        """Ask every worker to finish what is in flight; once."""
        if self._stopping:
            return
        self._stopping = True
        self._kill_at = time.monotonic() + _GRACE
        for worker in self.workers.values():
            worker.tell("stop")
        for name in (*self._restart_at, *self._left):
            self._give_up(self.workers[name], error="")

    def wind_down(self) -> None:
        """Start nobody again but those that are away already."""
        self._ending = True
        for worker in self.workers.values():
            worker.tell("final")

    def change(self, order: ChangeOrder) -> None:
        """One step of a change to stages of this host. Raises FollowspotError. Safe beside `attend`."""
        if self._change.in_the_way_of(order):
            raise FollowspotError("another change is under way; try again when it is done")
        change = HostChange(order, self.plan, self.name)
        for name in change.parts:
            if self.workers[name].phase != "running":
                raise FollowspotError(f"worker {name} is {self.workers[name].phase}; try again in a moment")
        self._change = change
        for name, part in change.parts.items():
            self.workers[name].tell("change", order=part.to_data())

    def move(self, order: MoveOrder) -> None:
        """One step of a move; done when the host is attended next."""
        self._moves.append(order)

    def states(self) -> dict[str, Any]:
        """What the stages here last told of their state."""
        return dict(self._states)

    def tap(self, tappings: Sequence[Tapping]) -> None:
        """Look at ports of the workers that are here and of those that will be; safe from any thread."""
        taps = [asdict(tapping) for tapping in tappings]
        self._taps += taps
        for worker in tuple(self.workers.values()):
            if worker.phase == "running":  # the others are told when they begin
                worker.tell("tap", taps=taps)

    def attend(self, timeout: float) -> None:
        """Hear what workers say, restart those that died, kill those that hang."""
        for key, _ in self._selector.select(timeout):
            self._listen(key.data)
        while self._moves:
            self._rearrange(self._moves.popleft())
        self._attend_clock()
        now = time.monotonic()
        if self.order.restart and self._running and not self._stopping:
            self._supervise(now)
        if self._kill_at is not None and now > self._kill_at:
            self._kill_at = None
            for worker in self.workers.values():
                if worker.busy:
                    worker.process.kill()

    def status(self) -> HostStatus:
        """The newest picture."""
        workers = tuple(worker.status() for worker in self.workers.values())
        counts = tuple(self.ledger.words.tolist())
        return HostStatus(
            workers,
            counts,
            tuple(self.news),
            self.out,
            self._change.status(),
            self.clock.status(),
            self.log.last,
        )

    def fileno(self) -> int:
        """Readable when `attend` has something to hear."""
        assert isinstance(self._selector, selectors.EpollSelector)
        return self._selector.fileno()

    def close(self) -> None:
        """Leave no process behind."""
        self.clock.close()
        for worker in self.workers.values():
            worker.end()
        if hasattr(self, "rings"):
            self.rings.close()
        self._selector.close()

    def _spawn(self, name: str, incarnation: int, *, again: bool = False) -> None:
        """Start one worker and tell it what it is."""
        worker = self.workers[name] = WorkerProcess(name, incarnation)
        self._selector.register(worker.channel, selectors.EVENT_READ, worker)
        if again:
            self.rings.renew(name)
        self._hand_over(self.rings.take(name))
        mine = [stage for stage in self.plan.stages if stage.worker == name]
        worker.tell(
            "plan",
            (self._ledger_fd,),
            worker=name,
            plan=self._plan_data,
            out=self.out,
            frames=self.order.frames,
            run=self.order.run,
            network=asdict(self.network.for_worker(self._peers())),
            incarnation=incarnation,
            restart=self.order.restart and not self._ending,
            states={s.name: self._states[s.name] for s in mine if s.name in self._states},
            clock=self.clock.correction(),
        )
        if uses_zenoh(self.plan, name) and not (self.hub or self.network.router):
            while not worker.locators and worker.busy:  # each connects to those before it
                self._listen(worker)

    def _hand_over(self, ends: Iterable[RingEnd]) -> None:
        """Give ends to their workers."""
        for end in ends:
            with end.socket:
                self.workers[end.worker].tell("ring", (end.socket.fileno(),), edge=end.edge, side=end.side)

    def _peers(self) -> list[str]:
        return [*self.hub, *(locator for worker in self.workers.values() for locator in worker.locators)]

    def _begin(self, worker: WorkerProcess) -> None:
        worker.phase = "running"
        worker.tell("start")
        if self._taps:
            worker.tell("tap", taps=self._taps)

    def _listen(self, worker: WorkerProcess) -> None:
        before = worker.phase
        channel = worker.channel.fileno()
        for message in worker.listen():
            if message["kind"] == "state":
                self._states[message["stage"]] = message["state"]
            elif message["kind"] == "log":
                self.log.add(*records_from_data(message["records"]))
            elif message["kind"] == "change":
                self._changed(worker.name, ChangeStatus(**message["status"]))
        if not worker.open:
            self._selector.unregister(channel)
        if before == "starting" and worker.phase == "ready" and self._running:
            self._begin(worker)
            running = [other.name for other in self.workers.values() if other.phase == "running"]
            self._hand_over(self.rings.join(worker.name, running))
            self._tell_news(f"worker {worker.name} is back", "info", worker.name)
        if worker.phase not in ("over", "absent") and not worker.busy:
            self._ended(worker)

    def _ended(self, worker: WorkerProcess) -> None:
        """A worker has reported, or died."""
        self._change.died(worker.name)
        report = worker.report
        failed_again = report is not None and bool(report.error) and worker.incarnation and worker.fired == 0
        if report is not None and not failed_again:
            worker.phase = "over"
            if report.error:
                self.log.say("error", report.error, worker=worker.name)
            return
        if report is None and worker.process.poll() is None:
            worker.process.kill()
        why = worker.obituary() if report is None else report.error
        if not (self.order.restart and self._running) or self._stopping or self._ending:
            self._give_up(worker, error="" if self._stopping and self.order.restart else why)
            return
        worker.phase = "absent"
        if worker.name in self._left:
            return
        wait = self._back_off.wait(worker.name, time.monotonic())
        self._restart_at[worker.name] = time.monotonic() + wait
        self._tell_news(f"{why}; it is started again in {wait:.1f} s", "warning", worker.name)

    def _attend_clock(self) -> None:
        """Tell the workers what to add to their clocks, and the user, once, where that is much."""
        if (correction := self.clock.news()) is not None:
            for worker in self.workers.values():
                worker.tell("clock", correction=correction)
        warning = self.clock.status().warning
        if warning and not self._clock_warned:
            self._clock_warned = True
            self._tell_news(warning, "warning")

    def _give_up(self, worker: WorkerProcess, error: str) -> None:
        """The worker has ended without a report, for good."""
        self._restart_at.pop(worker.name, None)
        worker.phase = "over"
        if error:
            self.log.say("error", error, worker=worker.name)
        warnings = () if error else (f"worker {worker.name} was not there at the end",)
        worker.report = WorkerReport(worker.name, 0, warnings=warnings, error=error)

    def _supervise(self, now: float) -> None:
        """Kill who hangs, start who died, and keep the state of those that live."""
        silent = self._pulse.silent({w.name: w.heard for w in self.workers.values()}, now)
        for name in silent:
            worker = self.workers[name]
            if worker.phase == "running" and worker.busy:
                line = f"worker {name} (process {worker.process.pid}) hangs; it is killed"
                self._tell_news(line, "warning", name)
                worker.process.kill()
                worker.heard = now
        for name in [name for name, at in self._restart_at.items() if at <= now]:
            del self._restart_at[name]
            self._spawn(name, self.workers[name].incarnation + 1, again=True)
        if now >= self._snapshot_at:
            self._snapshot_at = now + _SNAPSHOT_PERIOD
            for worker in self.workers.values():
                if worker.phase == "running":
                    worker.tell("snapshot")

    def _rearrange(self, order: MoveOrder) -> None:
        """Let workers leave, or let all take the places that a plan gives them."""
        self._left.update(order.leaving)
        for name in order.leaving:
            self.workers[name].tell("leave")
        if order.plan is None:
            return
        self._plan_data, self.plan = order.plan, plan_from_data(order.plan)
        self._states.update(order.states)
        mine = [worker.name for worker in host_workers(self.plan, self.name)]
        self.rings.rearrange(self.plan, set(mine))
        later = 1 + max((worker.incarnation for worker in self.workers.values()), default=0)
        self.workers = {name: worker for name, worker in self.workers.items() if name in mine}
        for name in [name for name in mine if name in self._left or name not in self.workers]:
            self._spawn(name, later, again=True)
        self._left.clear()

    def _changed(self, worker: str, answer: ChangeStatus) -> None:
        """A worker's answer; who is started again from now on gets the stages that have taken over."""
        if self._change.heard(worker, answer):
            stages = self._change.parts[worker].stages
            self.plan = with_stages(self.plan, stages)
            self._plan_data = plan_to_data(self.plan)
            for stage in stages:
                self._states.pop(stage.name, None)

    def _tell_news(self, line: str, level: Level, worker: str = "") -> None:
        self.log.say(level, line, worker=worker)
        self.news.append(line)
        del self.news[:-_MAX_NEWS]


def _memory(file: Path | None, size: int) -> int:
    """A descriptor of memory for the ledger, of a file where one is given: what it holds stays."""
    if file is None:
        fd = os.memfd_create("followspot-ledger", os.MFD_CLOEXEC)
    else:
        fd = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
    os.ftruncate(fd, size)
    return fd
