"""Stages and edges that come and go in a worker while it runs: built beside those that work, then connected.

Stages that stay keep their state, their outputs and what waits for them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

from followspot.errors import FollowspotError
from followspot.graph.plan import PlannedEdge, PlannedStage
from followspot.worker.build import Builder
from followspot.worker.change.departure import close_leaving, discard_sampled
from followspot.worker.change.remote_ends import RemoteEnds
from followspot.worker.change.replacement import (
    Replacement,
    build_replacements,
    discard_all,
    dry_run,
    fits,
    is_same,
)
from followspot.worker.edge_factory import EdgeFactory
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.sampled_input import NearestInput
from followspot.worker.ledger import COLUMNS, Ledger
from followspot.worker.runners.error_policy import StageError
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler
from followspot.worker.wiring import RunOptions, Wiring


class Rewiring:
    """The change of a worker to a new plan: stage runners that join, stay, or leave.

    wiring, edge_factory: of the new plan; ledger: with rows for its edges; rewired: gets the new stages once
    they have taken over.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        wiring: Wiring,
        name: str,
        ledger: Ledger,
        options: RunOptions,
        edge_factory: EdgeFactory,
        rewired: Callable[[Sequence[StageRunner]], None] = lambda new: None,
    ) -> None:
        """Build and set up all that is new, in any thread, while the worker works on.

        Raises FollowspotError with the reason; what was built is closed then.
        """
        self.scheduler = scheduler
        self.wiring = wiring
        self._rewired = rewired
        self._builder = Builder(wiring, name, ledger, replace(options, resumed=True), edge_factory)
        self._builder.pace = scheduler.pace
        present = {runner.name: runner for runner in scheduler.runners}
        self._stays = {
            stage.name: present[stage.name]
            for stage in self._builder.mine
            if stage.name in present and fits(present[stage.name], stage)
        }
        self.leaving = [runner for runner in scheduler.runners if runner.name not in self._stays]
        self._queues = {
            queue.row // COLUMNS: queue
            for runner in scheduler.runners
            for port in runner.join.ports
            for queue in port.queues
        }
        self.replacements: list[Replacement] = []
        self.new: list[StageRunner] = []
        self._ends: RemoteEnds | None = None
        try:
            self._build()
            self._ends = RemoteEnds(scheduler, self._builder, self._stays)
        except FollowspotError:
            self.discard()
            raise

    def wait_matched(self, wanted: Callable[[], bool]) -> None:
        """See `EdgeFactory.wait_matched`; in the thread that built it."""
        self._builder.edge_factory.wait_matched(wanted)

    def dry_run(self) -> None:
        """Find out whether replacements can carry on from the stages that work. Raises FollowspotError."""
        try:
            dry_run(self.replacements)
        except FollowspotError:
            self.discard()
            raise

    @property
    def window(self) -> int:
        """The widest window, ns, in which an input of a stage that comes or goes matches messages."""
        joins = [runner.join for runner in (*self.leaving, *self.new)]
        matched = [queue for join in joins if len(join.members) > 1 for queue in join.members]
        near = [one for join in joins for one in join.sampled if isinstance(one, NearestInput)]
        return max((queue.window for queue in (*matched, *(one.queue for one in near))), default=0)

    def calm(self) -> bool:
        """Whether no join of a stage that goes waits for the rest of a set: a live source has yet to give it.
        In a replay, what it has is all that comes.
        """
        return not (
            self.wiring.live
            and any(queue.messages for runner in self.leaving for queue in runner.join.members)
        )

    def leave(self, names: Collection[str] | None = None) -> None:
        """Let stages that go give what waits for partners that will not come any more; call at rest.

        names: of the stages, in this worker or not; None for all that go.
        """
        for runner in self.leaving:
            if names is None or runner.name in names:
                runner.leave()
                self.scheduler.drain()

    def take_over(self, *, fresh: bool) -> None:
        """Put the new stages and edges in; call at rest, in the worker's thread, after `leave`.

        fresh: begin replacements without checkpoints. Raises FollowspotError if one cannot restore that of
        the stage before: the old stages and edges are there then.
        """
        if not fresh:
            self.dry_run()
        for runner in self.leaving:
            close_leaving(runner)
        for found in self.replacements:
            found.take_over()
        runners = []
        for rank, stage in enumerate(self._builder.mine):
            runner = self._stays.get(stage.name) or next(new for new in self.new if new.name == stage.name)
            runner.rank = rank
            if stage.name in self._stays:
                self._reconnect(runner, stage)
            runners.append(runner)
        assert self._ends is not None
        self._ends.exchange({runner.name: runner for runner in self.new})
        self._builder.runners = runners
        self._builder.connect_wakeups(self.scheduler)
        self.scheduler.rearrange(runners)
        self._rewired(self.new)

    def close_old(self) -> None:
        """Close the ends of edges that left: all workers have the new plan."""
        if self._ends is not None:
            self._ends.close_old()

    def discard(self) -> None:
        """Close the stages and edges that were built."""
        self._builder.edge_factory.forget()
        discard_all(self.replacements)
        for runner in self.new:
            runner.retire(runner.stage)
        self.replacements, self.new = [], []

    def _build(self) -> None:
        """Build the queues, the stages that come, and replacements of stages that stay but change."""
        builder = self._builder
        for stage in builder.mine:
            for number in self.wiring.into[stage.name]:
                builder.inputs.queues[number] = self._queues.get(number) or builder.inputs.queue(number)
        for rank, stage in enumerate(builder.mine):
            if stage.name not in self._stays:
                self._add(rank, stage)
        changed = [
            stage
            for stage in builder.mine
            if stage.name in self._stays and not is_same(self._stays[stage.name], stage)
        ]
        self.replacements = build_replacements(self.scheduler, changed)

    def _add(self, rank: int, stage: PlannedStage) -> None:
        """Build and set up a new stage. Raises FollowspotError."""
        try:
            runner = self._builder.runner(rank, stage)
            self.new.append(runner)
            runner.setup()
        except StageError as error:
            why = error.__cause__ or error
            text = f"stage {stage.name} ({stage.uses}) cannot be built: {type(why).__name__}: {why}"
            raise FollowspotError(text) from error

    def _reconnect(self, runner: StageRunner, stage: PlannedStage) -> None:
        """Give a stage that stays the inputs and readers of the new plan."""
        wiring, inputs = self.wiring, self._builder.inputs
        runner.on_error = stage.on_error
        runner.deadline = wiring.deadline[stage.name] if wiring.live and runner.join.ports else None
        readers = {}
        for port, output in runner.outputs:
            output.lateness = wiring.lateness[stage.name]
            numbers = [n for n in wiring.out_of[stage.name] if wiring.plan.edge(n).from_port == port]
            local = [inputs.queues[n] for n in numbers if wiring.plan.edge(n).kind == "reference"]
            for queue in local:
                if queue not in output.queues:
                    queue.watermark = output.announced
            readers[port] = local
        runner.reconnect(readers)
        if runner.join.ports:
            for number in wiring.into[stage.name]:
                self._adapt(inputs.queues[number], wiring.plan.edge(number))
            join = inputs.join(stage)
            join.carry_on(runner.join)
            discard_sampled(runner.join, [queue for one in join.sampled for queue in one.queues])
            runner.join = join

    def _adapt(self, queue: InputQueue, edge: PlannedEdge) -> None:
        """Let a queue know what the new plan says of its stream."""
        queue.lateness = self.wiring.lateness[edge.from_stage]
        queue.answers = self.wiring.circular(edge)
        queue.window = self.wiring.tolerance(edge)
