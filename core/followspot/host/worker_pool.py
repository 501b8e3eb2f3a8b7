"""The worker pool of a host: the workers of a run there, the rings between them, and the messages to them."""

from __future__ import annotations

import selectors
import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from followspot.control.dispatch import Handlers, Request
from followspot.control.host import RunOrder
from followspot.control.lifecycle import EndWorkers, StartRun
from followspot.control.relay import Relayed
from followspot.control.swap import ChangeStatus
from followspot.control.worker_messages import ChangeAnswer, Log, StageCheckpoint
from followspot.control.worker_orders import BuildWorker, Correction, TakeRing
from followspot.errors import FollowspotError
from followspot.graph.change.move import host_workers
from followspot.graph.change.stages import with_stages
from followspot.graph.plan import MAX_NEW_EDGES, Plan, PlannedStage
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.host.rings import RingEnd, Rings
from followspot.host.worker_process import WorkerProcess
from followspot.host.worker_starts import WorkerStarts
from followspot.log.run_log import RunLog
from followspot.transport.zenoh.network import Network


class WorkerPool:
    """Starts workers, connects them by rings and receives their messages. The supervisor decides when.

    host: name of the host; ledger: descriptor of the shared ledger memory; network, hub: see `LocalHost`;
    log: gets the log records of workers; in_process: workers that are threads of this process.
    """

    def __init__(
        self,
        host: str,
        order: RunOrder,
        ledger: int,
        network: Network,
        hub: Sequence[str],
        log: RunLog,
        in_process: Collection[str] = (),
    ) -> None:
        self.order = order
        self.plan: Plan = plan_from_data(order.plan)
        self._rows = self.plan.rows + MAX_NEW_EDGES
        self.workers: dict[str, WorkerProcess] = {}
        self.over = set(order.over)
        """Workers of any host that have ended."""
        self.states: dict[str, Any] = {}
        """The newest checkpoint of each stage."""
        self._host = host
        self._plan_data = order.plan
        self._ledger = ledger
        self._network = network
        self._hub = tuple(hub)
        self._log = log
        self._selector = selectors.DefaultSelector()
        self._rings = Rings(self.plan, set(self.names()))
        for name in order.over:
            self._rings.discard(name)
        self._starts = WorkerStarts(self.names(), in_process, [stage.uses for stage in self.plan.stages])
        self._standing_orders: list[Relayed] = []
        """Relayed orders to repeat to workers that start later."""
        self._answers: list[tuple[str, ChangeStatus]] = []
        self._begun = 0
        """When the first worker began, ns of the monotonic clock."""

    def names(self) -> list[str]:
        """The workers that the plan places on this host."""
        return [worker.name for worker in host_workers(self.plan, self._host)]

    def spawn(
        self,
        name: str,
        incarnation: int,
        correction: Correction,
        *,
        again: bool = False,
        fired: int | None = None,
    ) -> None:
        """Start a worker and send it its plan. Raises OSError.

        correction: offsets to add to its clocks, ns; again: True if other workers may be running already;
        fired: frames that its sinks did elsewhere, None if it goes on from its earlier incarnation.
        """
        before = self.workers.get(name)
        if fired is None:
            fired = self.order.fired.get(name, 0) if before is None else before.status().fired
        worker = self.workers[name] = WorkerProcess(
            name, incarnation, self._starts.start, self._handlers(name), fired
        )
        self._selector.register(worker.channel, selectors.EVENT_READ, worker)
        if again:
            self._rings.renew(name)
        self._hand_over(self._rings.take(name))
        own = [stage.name for stage in self.plan.stages if stage.worker == name]
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
            states={stage: self.states[stage] for stage in own if stage in self.states},
            clock=correction,
        )
        worker.channel.send_if_open(order, (self._ledger,))
        if self.plan.uses_zenoh(name) and not (self._hub or self._network.router):
            while not worker.locators and worker.busy:  # each worker connects to those before it
                self._receive_from(worker)

    def begin(self, worker: WorkerProcess) -> None:
        """Start the stages of a worker."""
        worker.begin()
        for order in tuple(self._standing_orders):
            worker.channel.send_if_open(order)
        self._begun = self._begun or time.monotonic_ns()
        worker.channel.send_if_open(StartRun(begun=self._begun))

    def join(self, worker: WorkerProcess) -> None:
        """Start the stages of a restarted worker, and connect it to the running ones."""
        self.begin(worker)
        running = [other.name for other in self.workers.values() if other.phase == "running"]
        self._hand_over(self._rings.join(worker.name, running))

    def receive(self, timeout: float) -> list[tuple[str, ChangeStatus]]:
        """Receive messages of workers for up to `timeout`, s; return their answers to changes, with names."""
        for key, _ in self._selector.select(timeout):
            self._receive_from(key.data)
        answers, self._answers = self._answers, []
        return answers

    def send_to_all(self, order: Request) -> None:
        """Send an order to all workers."""
        for worker in tuple(self.workers.values()):
            worker.channel.send_if_open(order)

    def ended(self, workers: Collection[str]) -> None:
        """Announce workers of any host that have ended, so that no worker waits for them."""
        self.over.update(workers)
        self.send_to_all(EndWorkers(workers=tuple(sorted(self.over))))

    def relay(self, order: Relayed) -> None:
        """Send an order to the running workers, and to the others when they begin. Safe from any thread."""
        self._standing_orders = order.standing(self._standing_orders)
        for worker in tuple(self.workers.values()):
            if worker.phase == "running":
                worker.channel.send_if_open(order)

    def change(self, stages: Sequence[PlannedStage]) -> None:
        """Replace stages of the plan; workers that start from now on get the new ones."""
        self.plan = with_stages(self.plan, stages)
        self._plan_data = plan_to_data(self.plan)
        for stage in stages:
            self.states.pop(stage.name, None)

    def check_rows(self, plan: Mapping[str, Any]) -> None:
        """Raise FollowspotError if the ledger has no rows for the edges of a new plan."""
        if plan_from_data(dict(plan)).rows > self._rows:
            raise FollowspotError(f"the run has had {MAX_NEW_EDGES} new edges: start it anew for more")

    def hand_over_rings(self, plan: Mapping[str, Any]) -> None:
        """Give running workers the ends of the rings that come with a new plan."""
        self._hand_over(self._rings.added(plan_from_data(dict(plan)), set(self.names())))

    def adopt(self, plan: Mapping[str, Any]) -> None:
        """Take a new plan in which stages stay in their workers, and new stages join running workers."""
        self._plan_data, self.plan = dict(plan), plan_from_data(dict(plan))
        there = {stage.name for stage in self.plan.stages}
        self.states = {name: state for name, state in self.states.items() if name in there}
        self._rings.rearrange(self.plan, set(self.names()))

    def rearrange(
        self, plan: Mapping[str, Any], states: Mapping[str, Any], left: Collection[str]
    ) -> list[str]:
        """Take a new plan; return the workers to start for it.

        states: checkpoints of moved and of replaced stages; left: workers that have left their old places.
        """
        before = {stage.name: stage.uses for stage in self.plan.stages}
        self._plan_data, self.plan = dict(plan), plan_from_data(dict(plan))
        same = {stage.name for stage in self.plan.stages if before.get(stage.name) == stage.uses}
        self.states = {name: state for name, state in self.states.items() if name in same} | dict(states)
        own = self.names()
        self._rings.rearrange(self.plan, set(own))
        self.workers = {name: worker for name, worker in self.workers.items() if name in own}
        return [name for name in own if name in left or name not in self.workers]

    def fileno(self) -> int:
        """Descriptor that is readable when a worker has sent a message."""
        assert isinstance(self._selector, selectors.EpollSelector)
        return self._selector.fileno()

    def close(self) -> None:
        """End all workers and close all rings that they have not taken."""
        for worker in self.workers.values():
            worker.end()
        self._starts.close()
        self._rings.close()
        self._selector.close()

    def _hand_over(self, ends: Iterable[RingEnd]) -> None:
        """Send ends of rings to their workers."""
        for end in ends:
            with end.socket:
                order = TakeRing(edge=end.edge, side=end.side)
                self.workers[end.worker].channel.send_if_open(order, (end.socket.fileno(),))

    def _peers(self) -> list[str]:
        return [*self._hub, *(locator for worker in self.workers.values() for locator in worker.locators)]

    def _receive_from(self, worker: WorkerProcess) -> None:
        channel = worker.channel.fileno()
        worker.receive()
        if not worker.open:
            self._selector.unregister(channel)

    def _handlers(self, worker: str) -> Handlers:
        """The messages of a worker that concern the whole pool."""
        return {
            StageCheckpoint: self._keep,
            ChangeAnswer: lambda message: self._answers.append((worker, message.status)),
            Log: lambda message: self._log.add(*message.records),
        }

    def _keep(self, message: StageCheckpoint) -> None:
        self.states[message.stage] = message.state
