"""A stage at work: its inputs, its outputs, and what happens when it raises."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, NamedTuple

from followspot.errors import FollowspotError
from followspot.graph.plan import ErrorPolicy
from followspot.messages import Header, Message
from followspot.outputs import WrongOutput, check_returned, untimed
from followspot.ports import ports
from followspot.stage import Stage
from followspot.transport.token import ABSENT, END
from followspot.worker.clock import Clock
from followspot.worker.join import Join
from followspot.worker.latency import LatencyHistogram
from followspot.worker.output_port import OutputPort

_capture_time = attrgetter("time")
RESTARTS = 5
"""How often a stage with policy `restart` is rebuilt before the run fails."""
MOST_PATHS = 64
"""Sources whose latency to a sink is measured apart; whoever sends names without end fills no memory."""
OTHERS = "others"
"""Stands for the sources beyond those."""
FIRST_BACK_OFF = 0.1
"""Wait before the first restart, s; it doubles each time."""


class StageError(FollowspotError):
    """A stage raised; the text names the stage, the message it was given, and the traceback."""

    def __init__(self, stage: str, header: Header | None, error: BaseException) -> None:
        when = f" at {header.source}#{header.seq}, {header.time / 1e9:.6f} s" if header else ""
        detail = "" if isinstance(error, FollowspotError) else _traceback(error)
        super().__init__(f"stage {stage} failed{when}: {type(error).__name__}: {error}{detail}")


@dataclass
class RunnerCount:
    """What a stage did."""

    fired: int = 0
    skipped: int = 0
    restarts: int = 0
    busy_ns: int = 0


class Firing(NamedTuple):
    """What a stage is given, and the header of what it makes of that."""

    arguments: Sequence[object]
    header: Header


class StageRunner:
    """One stage instance of this worker.

    build: makes the stage anew (policy `restart`); join: its inputs, empty for a source; outputs: by port.
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
        clock: Clock = Clock(),  # of a host that nobody corrects
    ) -> None:
        """Build the stage. Raises StageError where that fails.

        rank: place in the topological order; deadline: longest time, s, from a message's entering the graph
        until a live join fires without those that are missing; None where it waits for ever; clock: of this
        host.
        """
        self.name = name
        self.rank = rank
        self.build = build
        try:
            self.stage = build()
        except Exception as error:
            raise StageError(name, None, error) from error
        self._declare()
        self.join = join
        self.outputs = tuple(outputs.items())
        self.single = self.outputs[0][1] if len(self.outputs) == 1 and self.outputs[0][0] == "out" else None
        self.on_error = on_error
        self.deadline = deadline
        self.overdue_at: float | None = None
        self.done = False
        self.open = False
        self.ready = False
        """Whether `setup` succeeded."""
        self.blocked = False
        """Whether an output is full; its reader's credit wakes this stage."""
        self.working = False
        """Whether the stage is at work on its own."""
        self.absent = False
        """Whether the outputs were declared absent."""
        self.count = RunnerCount()
        self.paths: dict[str, LatencyHistogram] = {}
        self.is_sink = not self.outputs
        self.clock = clock
        self._passed = -END
        """The bound that the outputs know."""

    def setup(self) -> None:
        """Set the stage up. Raises StageError."""
        self.open = True
        try:
            self.stage.setup()
        except Exception as error:
            raise StageError(self.name, None, error) from error
        self.ready = True

    def step(self) -> None:
        """Fire as often as inputs and outputs allow. Raises StageError where the policy is `fail`."""
        while (fire_at := self.due()) is not None:
            firing = self.take(fire_at)
            self.deliver(self.run(firing), firing.header)
            if not self.has_more():
                break

    def due(self) -> int | None:
        """Capture time, ns, of the firing that inputs and outputs allow now; None where they allow none."""
        if self.done:
            self._discard_rest()
            return None
        for queue in self.join.dropping:
            queue.shed()
        overdue = self.deadline is not None and self._overdue(self.deadline)
        fire_at = self.join.ready(overdue=overdue)
        if fire_at is None:
            self._idle()
            if overdue:  # it waits for feedback, which no deadline cuts short
                self.overdue_at = None
            return None
        self.blocked = not self.has_room()
        return None if self.blocked else fire_at

    def take(self, fire_at: int) -> Firing:
        """Take the inputs of the firing that is due at this time."""
        arguments, fired = self.join.take(fire_at)
        self._passed = self.join.closed + 1
        self.absent = False
        return Firing(arguments, _header(fired, fire_at))

    def run(self, firing: Firing) -> Any:
        """What the stage returns, None where it raised. Raises StageError where the policy is `fail`."""
        started = time.monotonic_ns()
        self.working = True
        try:
            result = self.stage.process(*firing.arguments)
        except Exception as error:
            self._recover(firing.header, error)
            result = None
        self.working = False
        self.count.busy_ns += time.monotonic_ns() - started
        return result

    def deliver(self, result: Any, header: Header) -> None:
        """The firing is over: hand out its result, or note how long it took to the end of the graph.

        Raises StageError where the result is not what the stage declares and the policy is `fail`.
        """
        self.count.fired += 1
        if result is not None and (type(result) is not self._only or not untimed(result.header)):
            result = self._checked(result, header)
        if self.is_sink:
            self._record(header, self.clock.now())
        else:
            self.send(result, header)

    def has_more(self) -> bool:
        """Whether inputs may hold more than the last firing took: messages, or a bound to pass on."""
        if self.deadline is not None:
            return True
        for queue in self.join.members:  # noqa: SIM110  # asked after every firing; any() costs twice as much
            if queue.messages or queue.watermark > self._passed:
                return True
        return False

    def has_room(self) -> bool:
        """Whether every output takes a message."""
        if self.single is not None:
            return self.single.has_room()
        return all(output.has_room() for _, output in self.outputs)

    def send(self, result: Any, header: Header) -> None:
        """Hand out what `process` returned; a port with nothing to say still settles its time."""
        if self.single is not None:
            self._say(self.single, result, header)
            return
        for port, output in self.outputs:
            self._say(output, None if result is None else getattr(result, port), header)

    def succeed(self, stage: Stage, build: Callable[[], Stage]) -> None:
        """Another stage, which is set up and fits the edges, does the work from the next firing on."""
        self.stage = stage
        self.build = build
        found = ports(type(stage))
        self._declare()
        self.join = self.join.read_by(found.inputs)
        self.outputs = tuple(named for named in self.outputs if found.output(named[0]) is not None)

    def _declare(self) -> None:
        """Read what the stage says that it hands out."""
        self.declared = ports(type(self.stage)).outputs
        self._only = self.declared[0].type if len(self.declared) == 1 else None
        """The type of all results but None, where there is one; dataclasses of messages have another."""

    def _checked(self, result: Any, header: Header) -> Any:
        """The result, or None where it is not what the stage declares. Raises StageError as :meth:`run`."""
        try:
            check_returned(self.declared, result)
        except WrongOutput as error:
            self._recover(header, error)
            return None
        return result

    def finish(self) -> None:
        """No more input: close the stage and end its outputs."""
        self.done = True
        self.close()
        self._discard_rest()
        for _, output in self.outputs:
            output.end()

    def close(self) -> None:
        """Close the stage; once, whoever asks first. Raises StageError: outputs may be incomplete."""
        if not self.open:
            return
        self.open = False
        try:
            self.stage.close()
        except Exception as error:
            if self.ready:  # else it is half set up, and why was said already
                raise StageError(self.name, None, error) from error

    def _discard_rest(self) -> None:
        """What comes after the last firing has no reader: feedback, or a sender that was started again."""
        for sampled in self.join.sampled:
            sampled.queue.clear()
        for queue in self.join.members:
            queue.clear()

    def _idle(self) -> None:
        """Nothing to fire: pass the bound on, end with the last input, or start the deadline."""
        watermark = self.join.watermark()
        if watermark == END:
            self.finish()
            return
        if watermark == ABSENT:
            self._pass_on_absence()
            return
        self.absent = False
        if watermark > self._passed:
            self._passed = watermark
            self.join.closed = max(self.join.closed, watermark - 1)  # for members that come back late
            for _, output in self.outputs:
                output.advance(watermark)

    def _pass_on_absence(self) -> None:
        """All inputs are away: who joins the outputs need not wait for them either; said once."""
        if not self.absent:
            self.absent = True
            for _, output in self.outputs:
                output.absent()

    def _overdue(self, deadline: float) -> bool:
        """Whether a message of a live join waits longer than it may; notes when one will."""
        since = self.join.waiting_since()
        self.overdue_at = None if since is None else (since - self.clock.steady) / 1e9 + deadline
        return self.overdue_at is not None and time.monotonic() >= self.overdue_at

    def _recover(self, header: Header, error: Exception) -> None:
        """Apply the error policy. Raises StageError where the run is to fail."""
        if self.on_error == "fail" or (self.on_error == "restart" and self.count.restarts >= RESTARTS):
            raise StageError(self.name, header, error) from error
        self.count.skipped += 1
        self.stage.context.warn(str(StageError(self.name, header, error)))
        if self.on_error == "restart":
            try:
                self._restart()
            except Exception as second:
                raise StageError(self.name, header, second) from error

    def _restart(self) -> None:
        """Build the stage anew after a wait; it carries on from the old one's state where it has one."""
        self.stage.context.pause(FIRST_BACK_OFF * 2**self.count.restarts)
        self.count.restarts += 1
        state = self.stage.state()
        self.stage.close()
        self.stage = self.build()
        self.stage.setup()
        if state is not None:
            self.stage.restore(state)

    def _record(self, header: Header, now: int) -> None:
        origin = header.source.partition("/")[0]
        path = self.paths.get(origin)
        if path is None:
            origin = origin if len(self.paths) < MOST_PATHS else OTHERS
            path = self.paths.setdefault(origin, LatencyHistogram())
        path.add(now - header.entered, header.source, header.seq)

    @staticmethod
    def _say(output: OutputPort, message: Message | None, header: Header) -> None:
        if message is None:
            output.advance(header.time + 1 + output.lateness)
        else:
            output.send(message, header)


def _header(fired: Sequence[Message], time: int) -> Header:
    """Header of an output: of the input that fired; for a join, of its first member at the join's time."""
    if len(fired) == 1:
        return fired[0].header
    headers = [message.header for message in fired]
    first = min(headers, key=_capture_time)
    return Header(first.source, first.seq, time, min([header.entered for header in headers]))


def _traceback(error: BaseException) -> str:
    return "\n" + "".join(traceback.format_exception(error)).rstrip()
