"""Build the inputs of a worker's stages from a plan: a queue for each edge, and the joins of these queues."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

from followspot.graph.depths import MAX_IN_TRANSIT
from followspot.graph.plan import PlannedEdge, PlannedStage
from followspot.message_checks.room_fit import fit_check
from followspot.message_checks.sealing import seal
from followspot.ports.specs import InputSpec
from followspot.transport.token import ABSENT
from followspot.worker.edge_factory import EdgeFactory
from followspot.worker.inputs.input_queue import UNCHANGED, InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.inputs.join_input import JoinInput
from followspot.worker.inputs.sampled_input import NearestInput, NewestInput, SampledInput, WindowInput
from followspot.worker.ledger import Ledger
from followspot.worker.wiring import RunOptions, Wiring

_ENDLESS = 1 << 30
"""Depth of an edge that drops messages, and so is never full."""


class InputBuilder:
    """Makes the input queues of a worker's stages, and the joins that read them.

    queues: those of all edges that end here, by the number of the edge.
    """

    def __init__(
        self, wiring: Wiring, ledger: Ledger, options: RunOptions, edge_factory: EdgeFactory
    ) -> None:
        self.wiring = wiring
        self.plan = wiring.plan
        self.ledger = ledger
        self.options = options
        self.edge_factory = edge_factory
        self.queues: dict[int, InputQueue] = {}

    def queue(self, number: int) -> InputQueue:
        """A new queue for an edge, with its reading end if the edge comes from another worker."""
        edge = self.plan.edge(number)
        lateness = self.wiring.lateness[edge.from_stage]
        depth, keep = self._limits(edge)
        queue = InputQueue(
            edge.name,
            self.ledger.words,
            self.ledger.row(number),
            depth=depth,
            lateness=lateness,
            keep=keep,
            window=self.wiring.tolerance(edge),
        )
        queue.answers = self.wiring.circular(edge)
        if edge.kind != "reference":
            kind = self.wiring.message_type(edge)
            queue.reader = self.edge_factory.reader(number, kind)
            queue.unfit = fit_check(kind, self.plan.room, self.wiring.stages[edge.from_stage].camera)
            if self.options.rejoin:
                queue.after_loss = ABSENT if self.wiring.live else UNCHANGED
        return queue

    def _limits(self, edge: PlannedEdge) -> tuple[int, int | None]:
        """Depth of an edge, and the number of messages beyond which it drops the oldest (None: never).

        A sampled input of a live stage does not wait for the stage to fire: else a camera that falls silent
        would hold up the stages whose results it samples, and these in turn hold up the camera.
        """
        if self.wiring.live and edge.drops:
            return _ENDLESS, edge.depth
        if self.wiring.live and self.wiring.sampled(edge):
            return edge.capacity, max(edge.capacity - MAX_IN_TRANSIT, edge.delay + 1)
        return edge.capacity, None

    def join(self, stage: PlannedStage) -> Join:
        """The join of all inputs of a stage, whose queues are there."""
        by_port: Mapping[str, list[int]] = defaultdict(list)
        for number in self.wiring.into[stage.name]:
            by_port[self.wiring.input_port(self.plan.edge(number)).name].append(number)
        input_ports = [self._input(port, by_port[port.name]) for port in self.wiring.ports[stage.name].inputs]
        closing = self.wiring.closing[stage.name]
        return Join(input_ports, lateness=closing, lag=None if self.wiring.live else self.wiring.lag)

    def _input(self, port: InputSpec, numbers: Iterable[int]) -> JoinInput:
        numbers = list(numbers)
        if numbers and self.wiring.sampled(self.plan.edge(numbers[0])):
            return JoinInput(port.name, joined=False, sampled=self._sampled(port, numbers))
        members = tuple(self.queues[n] for n in numbers)
        return JoinInput(port.name, joined=port.several, members=members)

    def _sampled(self, port: InputSpec, numbers: Sequence[int]) -> SampledInput:
        queues = [self.queues[n] for n in numbers]
        if port.kind == "window":
            return WindowInput(queues)
        edge = self.plan.edge(numbers[0])
        if port.kind == "nearest":
            return NearestInput(queues[0], tolerance=self.wiring.tolerance(edge))
        initial = seal(self.wiring.message_type(edge).empty()) if edge.delay else None
        return NewestInput(queues[0], delay=edge.delay, timed=self.wiring.timed(edge), initial=initial)
