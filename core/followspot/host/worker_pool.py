"""The workers of a host's part of a run: their processes, the rings between them, what each is told."""

from __future__ import annotations

import selectors
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from followspot.control.dispatch import Request
from followspot.control.host import RunOrder
from followspot.control.lifecycle import EndWorkers, StartRun
from followspot.control.relay import Relayed, with_order
from followspot.control.swap import ChangeStatus
from followspot.control.worker_messages import Change, Log, State
from followspot.control.worker_orders import BuildWorker, TakeRing
from followspot.graph.change import with_stages
from followspot.graph.move import host_workers
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.ship import plan_from_data, plan_to_data
from followspot.host.rings import RingEnd, Rings
from followspot.host.worker_process import Start, WorkerProcess, start_process
from followspot.log.run_log import RunLog
from followspot.transport.zenoh.network import Network
from followspot.worker.edge_links import uses_zenoh


class WorkerPool:
    """Starts workers, introduces them to each other, hears them; whether to start one is not its business.

    host: whose workers; ledger: descriptor of the memory that all count in; network, hub: see `LocalHost`;
    log: takes what workers say; start: how a worker is started.
    """

    def __init__(
        self,
        host: str,
        order: RunOrder,
        ledger: int,
        network: Network,
        hub: Sequence[str],
        log: RunLog,
        start: Start = start_process,
    ) -> None:
        self.order = order
        self.plan: Plan = plan_from_data(order.plan)
        self.workers: dict[str, WorkerProcess] = {}
        self.over = set(order.over)
        """Workers, here or elsewhere, that have come to their end."""
        self.states: dict[str, Any] = {}
        """What each stage last told of its state."""
        self._host = host
        self._plan_data = order.plan
        self._ledger = ledger
        self._network = network
        self._hub = tuple(hub)
        self._log = log
        self._start = start
        self._selector = selectors.DefaultSelector()
        self._rings = Rings(self.plan, set(self.names()))
        for name in order.over:
            self._rings.give_up(name)
        self._standing: list[Relayed] = []
        """Orders for workers that begin later."""
        self._answers: list[tuple[str, ChangeStatus]] = []

    def names(self) -> list[str]:
        """Of the workers that the plan has for this host."""
        return [worker.name for worker in host_workers(self.plan, self._host)]

    def spawn(self, name: str, incarnation: int, correction: tuple[int, int], *, again: bool = False) -> None:
        """Start a worker and tell it what it is. Raises OSError.

        correction: what to add to its clocks, ns; again: whether others may be at work already.
        """
        worker = self.workers[name] = WorkerProcess(name, incarnation, self._start)
        self._selector.register(worker.channel, selectors.EVENT_READ, worker)
        if again:
            self._rings.renew(name)
        self._hand_over(self._rings.take(name))
        mine = [stage.name for stage in self.plan.stages if stage.worker == name]
        order = BuildWorker(
            worker=name,
            plan=self._plan_data,
            out=self.order.out or "",
            frames=self.order.frames,
            run=self.order.run,
            network=self._network.for_worker(self._peers()),
            incarnation=incarnation,
            restart=self.order.restart,
            over=tuple(sorted(self.over)),
            states={stage: self.states[stage] for stage in mine if stage in self.states},
            clock=correction,
        )
        worker.tell(order, (self._ledger,))
        if uses_zenoh(self.plan, name) and not (self._hub or self._network.router):
            while not worker.locators and worker.busy:  # each connects to those before it
                self._listen(worker)

    def begin(self, worker: WorkerProcess) -> None:
        """All others are ready as well: go."""
        worker.phase = "running"
        for order in tuple(self._standing):
            worker.tell(order)
        worker.tell(StartRun())

    def join(self, worker: WorkerProcess) -> None:
        """Let a worker begin among others that are at work."""
        self.begin(worker)
        running = [other.name for other in self.workers.values() if other.phase == "running"]
        self._hand_over(self._rings.join(worker.name, running))

    def hear(self, timeout: float) -> list[tuple[str, ChangeStatus]]:
        """Take in what workers say within `timeout`, s; what they answer to changes, by worker."""
        for key, _ in self._selector.select(timeout):
            self._listen(key.data)
        answers, self._answers = self._answers, []
        return answers

    def tell(self, order: Request) -> None:
        """Say the same to all workers."""
        for worker in tuple(self.workers.values()):
            worker.tell(order)

    def ended(self, workers: Collection[str]) -> None:
        """These have come to their end, here or elsewhere: nobody need wait for them."""
        self.over.update(workers)
        self.tell(EndWorkers(workers=tuple(sorted(self.over))))

    def relay(self, order: Relayed) -> None:
        """Tell the workers that are at work, and the others when they begin; safe from any thread."""
        self._standing = with_order(self._standing, order)
        for worker in tuple(self.workers.values()):
            if worker.phase == "running":
                worker.tell(order)

    def change(self, stages: Sequence[PlannedStage]) -> None:
        """Who is started from now on gets these stages in the place of those of the same names."""
        self.plan = with_stages(self.plan, stages)
        self._plan_data = plan_to_data(self.plan)
        for stage in stages:
            self.states.pop(stage.name, None)

    def rearrange(
        self, plan: Mapping[str, Any], states: Mapping[str, Any], left: Collection[str]
    ) -> list[str]:
        """The plan is another one now; the workers that are to be started for it.

        states: of stages that come from elsewhere; left: workers that have left their old places.
        """
        self._plan_data, self.plan = dict(plan), plan_from_data(dict(plan))
        self.states.update(states)
        mine = self.names()
        self._rings.rearrange(self.plan, set(mine))
        self.workers = {name: worker for name, worker in self.workers.items() if name in mine}
        return [name for name in mine if name in left or name not in self.workers]

    def fileno(self) -> int:
        """Readable when there is something to hear."""
        assert isinstance(self._selector, selectors.EpollSelector)
        return self._selector.fileno()

    def close(self) -> None:
        """Leave no process behind."""
        for worker in self.workers.values():
            worker.end()
        self._rings.close()
        self._selector.close()

    def _hand_over(self, ends: Iterable[RingEnd]) -> None:
        """Give ends to their workers."""
        for end in ends:
            with end.socket:
                order = TakeRing(edge=end.edge, side=end.side)
                self.workers[end.worker].tell(order, (end.socket.fileno(),))

    def _peers(self) -> list[str]:
        return [*self._hub, *(locator for worker in self.workers.values() for locator in worker.locators)]

    def _listen(self, worker: WorkerProcess) -> None:
        channel = worker.channel.fileno()
        for message in worker.listen():
            match message:
                case State():
                    self.states[message.stage] = message.state
                case Change():
                    self._answers.append((worker.name, message.status))
                case Log():
                    self._log.add(*message.records)
        if not worker.open:
            self._selector.unregister(channel)
