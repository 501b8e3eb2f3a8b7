"""Build one worker from a plan: its stage runners, and the queues and ports between them.

`build_inputs` makes the queues, and the joins that read them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import groupby

import numpy as np

from followspot.context import Context, SourceLoss
from followspot.graph.frame_count import accompanying_sources
from followspot.graph.plan import PlannedStage
from followspot.message_checks.room_fit import fit_check
from followspot.messages import Array
from followspot.ports.firing import FIRINGS
from followspot.ports.specs import Giving
from followspot.stage import Stage
from followspot.transport.edge import PortWriter
from followspot.worker.build_inputs import InputBuilder
from followspot.worker.edge_factory import EdgeFactory, NoEdgeFactory
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.ledger import LOST, Ledger
from followspot.worker.output_port import OutputPort
from followspot.worker.pace import Pace
from followspot.worker.runners.deferred_runner import DeferredRunner
from followspot.worker.runners.lagged_runner import LaggedRunner
from followspot.worker.runners.live_source import LiveSourceRunner
from followspot.worker.runners.outputs_runner import OutputsRunner
from followspot.worker.runners.source import SourceRunner
from followspot.worker.runners.stage_runner import StageRunner
from followspot.worker.scheduler import Scheduler
from followspot.worker.wiring import RunOptions, Wiring

RUNNERS: Mapping[Giving, type[StageRunner]] = {
    "one": StageRunner,
    "several": OutputsRunner,
    "later": DeferredRunner,
    "lagged": LaggedRunner,
}


def build_worker(
    wiring: Wiring, name: str, ledger: Ledger, options: RunOptions, edge_factory: EdgeFactory | None = None
) -> Scheduler:
    """The scheduler of that worker, with all its stages built and none of them set up."""
    return Builder(wiring, name, ledger, options, edge_factory or NoEdgeFactory()).build()


class Builder:
    """Collects the parts of one worker while it builds the stages in order."""

    def __init__(
        self, wiring: Wiring, name: str, ledger: Ledger, options: RunOptions, edge_factory: EdgeFactory
    ) -> None:
        self.wiring = wiring
        self.plan = wiring.plan
        self.words = ledger.words
        self.ledger = ledger
        self.options = options
        self.edge_factory = edge_factory
        self.mine = [stage for stage in self.plan.stages if stage.worker == name]
        self.accompanying = accompanying_sources(self.plan)
        self.names = {stage.name for stage in self.mine}
        self.inputs = InputBuilder(wiring, ledger, options, edge_factory)
        self.writers: dict[PortWriter, str] = {}
        """The stage that owns each writer."""
        self.runners: list[StageRunner] = []
        self.pace = Pace()

    def build(self) -> Scheduler:
        """Make input queues, then the stage runners that join them, then what schedules the runners."""
        for stage in self.mine:
            for number in self.wiring.into[stage.name]:
                self.inputs.queues[number] = self.inputs.queue(number)
        for rank, stage in enumerate(self.mine):
            self.runners.append(self.runner(rank, stage))
        remote = [queue for queue in self.inputs.queues.values() if queue.reader is not None]
        runners = {runner.name: runner for runner in self.runners}
        writers = [(writer, runners[name]) for writer, name in self.writers.items()]
        scheduler = Scheduler(self.runners, remote, writers, self.pace)
        self.connect_wakeups(scheduler)
        return scheduler

    def connect_wakeups(self, scheduler: Scheduler) -> None:
        """Let a queue mark its reader when a message comes, and its sender when it has room again."""
        ranks = {stage.name: rank for rank, stage in enumerate(self.mine)}
        for number, queue in self.inputs.queues.items():
            edge = self.plan.edge(number)
            queue.wake = partial(scheduler.schedule.mark, ranks[edge.to_stage])
            if edge.kind == "reference":
                queue.reopened = partial(scheduler.schedule.mark, ranks[edge.from_stage])
        for runner in self.runners:
            if isinstance(runner, DeferredRunner):
                runner.answered = partial(
                    scheduler.between_firings, partial(scheduler.schedule.mark, runner.rank)
                )
            for queue in (queue for sampled in runner.join.sampled for queue in sampled.queues):
                wake = partial(scheduler.schedule.mark_waiting, runner, queue)
                queue.wake = wake if queue.keep is None else partial(_shed, queue, wake)

    def runner(self, rank: int, stage: PlannedStage) -> StageRunner:
        """The runner of a stage, whose input queues are there; builds the stage. Raises StageError."""
        outputs = self._outputs(stage)
        context = self.context(stage, tuple(outputs.values()))
        for output in outputs.values():
            output.refused = context.warn
            output.waits_for_readers = self.options.rejoin and not self.wiring.live
        build = partial(self.wiring.classes[stage.name], context, **stage.params)
        source = self.wiring.ports[stage.name].source
        make = self._source_runner if source else self._stage_runner
        runner = make(rank, stage, build, outputs)
        runner.uses = stage.uses
        return runner

    def _source_runner(
        self, rank: int, stage: PlannedStage, build: Callable[[], Stage], outputs: Mapping[str, OutputPort]
    ) -> StageRunner:
        """The runner of a source."""
        kind = LiveSourceRunner if stage.live else SourceRunner
        source = kind(
            stage.name,
            rank,
            build,
            Join((), lateness=0),
            outputs,
            on_error=stage.on_error,
            clock=self.options.clock,
        )
        source.accompanying = stage.name in self.accompanying
        source.limit = None if source.accompanying else self.options.frames
        if isinstance(source, LiveSourceRunner):
            source.depth = stage.depth
        return source

    def _stage_runner(
        self, rank: int, stage: PlannedStage, build: Callable[[], Stage], outputs: Mapping[str, OutputPort]
    ) -> StageRunner:
        """The runner of a stage with inputs."""
        deadline = self.wiring.deadline[stage.name] if self.wiring.live else None
        runner = RUNNERS[self.wiring.ports[stage.name].gives](
            stage.name,
            rank,
            build,
            self.inputs.join(stage),
            outputs,
            on_error=stage.on_error,
            deadline=deadline,
            clock=self.options.clock,
            groups=self.wiring.groups,
        )
        runner.paths.limits = self.wiring.limits(stage)
        if isinstance(runner, DeferredRunner):
            runner.concurrency = stage.concurrency
        return runner

    def context(self, stage: PlannedStage, outputs: Sequence[OutputPort] = ()) -> Context:
        """The context of a stage: its view of the run."""
        return Context(
            name=stage.name,
            room=self.plan.room_of(stage),
            member=stage.member,
            out=self.options.out,
            seed=self.plan.seed,
            receives=self.wiring.received_types(stage.name),
            warn=partial(self.options.warn, stage.name),
            loan=partial(_loan, outputs),
            pause=self.pace.wait_in_thread if stage.live else self.pace.wait,
            resumed=self.options.resumed,
            lost=partial(_lost_at_source, outputs),
            run_begun=self.options.clock.run_begun,
        )

    def _outputs(self, stage: PlannedStage) -> dict[str, OutputPort]:
        """The output ports of a stage by name, with all their edges."""
        outputs = {}
        found = self.wiring.ports[stage.name]
        ways = {n: self.plan.edge(n).from_port for n in self.wiring.out_of[stage.name]}
        firings = found.output(FIRINGS) if FIRINGS in ways.values() else None
        for port in (*found.outputs, *([firings] if firings is not None else [])):
            output = OutputPort(port.type, self.words, lateness=self.wiring.lateness[stage.name])
            output.unfit = fit_check(port.type, self.plan.room, stage.camera)
            numbers = [number for number, name in ways.items() if name == port.name]
            for _, group in groupby(sorted(numbers, key=self.writer_key), key=self.writer_key):
                self._attach(output, list(group), stage.name)
            outputs[port.name] = output
        return outputs

    def _attach(self, output: OutputPort, numbers: list[int], stage: str) -> None:
        """Add edges of the same way to an output port."""
        kind = self.plan.edge(numbers[0]).kind
        if kind == "reference":
            for number in numbers:
                self._count_lost(number)
            output.connect([self.inputs.queues[n] for n in numbers])
            return
        writer = self.edge_factory.writer(numbers, kind)
        names = [self.plan.edge(n).name for n in numbers]
        output.attach(writer, names, [self.ledger.row(n) for n in numbers])
        self.writers[writer] = stage

    def _count_lost(self, number: int) -> None:
        """Count as lost the messages in flight on an edge within the worker when its earlier process died."""
        self.words[self.ledger.row(number) + LOST] += self.ledger.count(number).in_flight

    def writer_key(self, number: int) -> str:
        """Edges of a port with equal keys share one writer; an edge that drops has a writer of its own.

        Edges over the network must also have come with the same change of the graph: they share a Zenoh key,
        and the stream of a Zenoh key has one beginning.
        """
        edge = self.plan.edge(number)
        if edge.drops and edge.kind != "reference":
            return f"{edge.shown_kind}, {number}"
        return f"{edge.shown_kind}, {self.plan.addition(number)}" if edge.kind == "zenoh" else edge.shown_kind


def _shed(queue: InputQueue, wake: Callable[[], None]) -> None:
    """Drop the messages that a sampled input no longer keeps when a new one comes."""
    queue.drop_oldest()
    wake()


def _lost_at_source(outputs: Sequence[OutputPort], kind: SourceLoss, number: int) -> None:
    for output in outputs:
        output.lost_at_source(kind, number)


def _loan(outputs: Sequence[OutputPort], shape: tuple[int, ...], dtype: str) -> Array:
    """An output array in shared memory if an edge offers one, else in private memory."""
    for output in outputs:
        array = output.loan(shape, dtype)
        if array is not None:
            return array
    return np.empty(shape, dtype)
