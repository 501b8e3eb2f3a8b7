"""A stage runner: it fires one stage when its inputs are ready, and sends the results."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from followspot.graph.plan import ErrorPolicy
from followspot.message_checks.outputs import untimed
from followspot.messages import Header, Message
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot.worker.clock import Clock
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join import Join
from followspot.worker.journal import Journal
from followspot.worker.latency import PathLatencies
from followspot.worker.output_port import OutputPort
from followspot.worker.runners.error_policy import RAISED, recover
from followspot.worker.runners.shared_state import WATCHED, check_read_only
from followspot.worker.runners.stage_streams import StageStreams

_capture_time = attrgetter("time")
Returned = TypeVar("Returned")


class FiringInputs(NamedTuple):
    """The arguments of `process`, and the header of its outputs."""

    arguments: Sequence[object]
    header: Header


class StageRunner(StageStreams):
    """Fires one stage instance of this worker, and sends its results.

    build: makes the stage, and makes it anew for the policy `restart`; join: its inputs, empty for a source;
    outputs: by port.
    """

    def __init__(
        self,
        name: str,
        rank: int,
        build: Callable[[], Stage],
        join: Join,
        outputs: Mapping[str, OutputPort],
        *,
        on_error: ErrorPolicy = "fail",
        deadline: float | None = None,
        clock: Clock = Clock(),  # of a host without offsets
        groups: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        """Build the stage. Raises StageError if that fails.

        rank: place in the topological order; deadline: longest time, s, from a message's entering the graph
        until a live join fires without its missing partners, None to wait for ever; clock: of this host;
        groups: the stage of the graph file, by instance.
        """
        super().__init__(name, build, join, outputs, on_error=on_error)
        self.rank = rank
        self.deadline = deadline
        self.overdue_at: float | None = None
        """When the deadline of the oldest waiting message passes, s, monotonic; None if none waits."""
        self.gives_up = False
        """Whether a deadline that has passed counts now. It does not while a message may still wait for a
        stage upstream in this worker."""
        self.blocked = False
        """Whether backpressure holds the stage up: an output is full until its reader gives credit."""
        self.working = False
        """Whether the stage is in `process` now."""
        self.paths = PathLatencies(groups)
        self.journal = Journal(self.outputs.firings)
        self.is_sink = self.outputs.none
        self.clock = clock

    def step(self) -> None:
        """Fire as often as inputs and outputs allow. Raises StageError if the policy is `fail`."""
        while self.fire():
            pass

    def fire(self) -> bool:
        """Fire once if inputs and outputs allow; whether more may follow. Raises StageError like `step`."""
        fire_at = self.due()
        if fire_at is None:
            return False
        firing = self.take(fire_at)
        self.deliver(self.run(firing), firing.header)
        return self.has_more()

    def due(self) -> int | None:
        """Capture time, ns, of the firing that inputs and outputs allow now; None if they allow none."""
        if self.done:
            self._discard_rest()
            return None
        for queue in self.join.dropping:
            queue.drop_oldest()
        overdue = self.deadline is not None and self._overdue(self.deadline)
        self.gives_up = False
        fire_at = self.join.ready(overdue=overdue)
        if fire_at is None:
            self._idle()
            if overdue:  # the stage waits for feedback, which no deadline cuts short
                self.overdue_at = None
            return None
        self.blocked = not self.outputs.has_room()
        return None if self.blocked else fire_at

    def take(self, fire_at: int) -> FiringInputs:
        """Take the inputs of the firing that is due at this time."""
        note = self.journal.before(self, fire_at) if self.journal.read else None
        arguments, fired = self.join.take(fire_at)
        self._passed = self.join.closed + 1
        self.absent = False
        header = _header(fired, fire_at)
        if note is not None:
            self.journal.after(self, header._replace(time=fire_at), note, arguments)
        return FiringInputs(arguments, header)

    def run(self, firing: FiringInputs) -> Any:
        """The result of the stage, None if it raised. Raises StageError if the policy is `fail`."""
        started = time.monotonic_ns()
        self.working = True
        try:
            result = self.stage.process(*firing.arguments)
            if self.count.fired < WATCHED:
                check_read_only(firing.arguments)
        except RAISED as error:
            recover(self, firing.header, error)
            result = None
        self.working = False
        self.count.busy_ns += time.monotonic_ns() - started
        return result

    def deliver(self, result: Any, header: Header) -> None:
        """End a firing: send its result, or note the latency if the stage is a sink.

        Raises StageError if the result is not what the stage declares and the policy is `fail`.
        """
        self.count.fired += 1
        if result is not None and (type(result) is not self._only or not untimed(result.header)):
            result = self._checked(result, header)
        if self.is_sink:
            self.paths.add(header, self.clock.now())
        else:
            self.outputs.send(result, header, self._following())
            self.note_budget(header)

    def note_budget(self, header: Header) -> None:
        """Note the latency of the messages that were sent, if a path with a budget ends here."""
        if self.paths.limits:
            self.paths.add_budgeted(header, self.clock.now())

    def has_more(self) -> bool:
        """Whether inputs may hold more than the last firing took: messages, or a later watermark."""
        if self.deadline is not None:
            return True
        for queue in self.join.members:  # noqa: SIM110  # asked after every firing; any() costs twice as much
            if queue.messages or queue.watermark > self._passed:
                return True
        return False

    def replace_stage(self, stage: Stage, build: Callable[[], Stage]) -> None:
        """Run another stage, which is set up and fits the edges, from the next firing on (hot swap)."""
        self.stage = stage
        self.build = build
        found = ports(type(stage))
        self._declare()
        self.join = self.join.read_by(found.inputs)
        self.outputs.keep(found)

    def reconnect(self, readers: Mapping[str, Sequence[InputQueue]]) -> None:
        """Have these readers in the same worker at each output, instead of the former ones."""
        for port, output in self.outputs:
            output.reconnect(readers[port])

    def exchange(self, output: OutputPort, change: Callable[[], Returned]) -> Returned:
        """Let `change` add or remove edges of an output to other workers; returns what it returns."""
        return change()

    def leave(self) -> None:
        """Fire with the messages that wait, without their missing partners: the stage leaves the graph."""
        while (
            not self.done
            and self.outputs.has_room()
            and (fire_at := self.join.ready(overdue=True)) is not None
        ):
            firing = self.take(fire_at)
            self.deliver(self.run(firing), firing.header)

    @property
    def owed(self) -> Sequence[Header]:
        """Headers of earlier firings whose messages are yet to come."""
        return ()

    @property
    def asks(self) -> bool:
        """Whether answers of the stage are under way, which will wake the worker."""
        return False

    def _overdue(self, deadline: float) -> bool:
        """Whether a message of a live join has waited beyond the deadline; notes when the next one will."""
        since = self.join.waiting_since()
        self.overdue_at = None if since is None else (since - self.clock.steady) / 1e9 + deadline
        if self.overdue_at is None or not (self.gives_up or deadline == 0):
            return False
        return time.monotonic() >= self.overdue_at


def _header(fired: Sequence[Message], time: int) -> Header:
    """Header of an output: that of the only input, or of a join's earliest member at the join's time."""
    if len(fired) == 1:
        return fired[0].header
    headers = [message.header for message in fired]
    first = min(headers, key=_capture_time)
    return Header(first.source, first.seq, time, min([header.entered for header in headers]))
