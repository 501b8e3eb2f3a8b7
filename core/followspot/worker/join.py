"""When a stage fires: the join of its inputs by capture time and watermark.

A join is complete when every member has a message in the window, or a watermark beyond the window. The rule
reads the streams alone and no clock, so any placement fires the same messages together. Only the deadline of
a live join depends on the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from followspot.messages import Message
from followspot.ports import InputSpec
from followspot.transport.token import ABSENT, END
from followspot.worker.input_queue import InputQueue, SampledInput
from followspot.worker.ledger import LATE, UNMATCHED


@dataclass(frozen=True)
class JoinInput:
    """One parameter of `process` and the edges that feed it: members of the join, or one sampled input.

    An optional input without an edge has neither; the stage gets None.
    """

    name: str
    joined: bool
    members: tuple[InputQueue, ...] = ()
    sampled: SampledInput | None = None


class Join:
    """The inputs of one stage.

    window: largest difference in capture time between members, ns; lateness: ns after a firing's time within
    which nothing else fires (the window, plus the lateness of the inputs).
    """

    def __init__(self, ports: Sequence[JoinInput], *, window: int, lateness: int) -> None:
        self.ports = tuple(ports)
        self.members = tuple(queue for port in ports for queue in port.members)
        self.sampled = tuple(port.sampled for port in ports if port.sampled is not None)
        self.required = tuple(queue for port in ports if not port.joined for queue in port.members)
        self.dropping = tuple(queue for queue in self.members if queue.keep is not None)
        """Members that keep only their newest messages."""
        self.only = self.members[0] if len(self.members) == len(self.ports) == 1 else None
        """The single member of the commonest stage, which fires for each message as it is."""
        self.window = window
        self.lateness = lateness
        self.closed = -END - 1
        """Capture time, ns, up to which everything was fired or discarded; before all times at first."""
        self.in_time = UNMATCHED
        """Ledger column of messages after their window closed: `LATE` once a deadline closed one."""

    def read_by(self, inputs: Sequence[InputSpec]) -> Join:
        """The same inputs for a stage that declares these ports, perhaps in another order; the only input of
        one stage is that of the other, whatever their names are.
        """
        known = {port.name: port for port in self.ports}
        if len(inputs) == len(self.ports) == 1:
            known = {inputs[0].name: self.ports[0]}
        arranged = [
            replace(known.get(p.name) or JoinInput(p.name, joined=False), joined=p.kind == "joined")
            for p in inputs
        ]
        join = Join(arranged, window=self.window, lateness=self.lateness)
        join.closed, join.in_time = self.closed, self.in_time
        return join

    def ready(self, *, overdue: bool = False) -> int | None:
        """Capture time, ns, of the next firing, or None while it is not certain.

        overdue: the deadline of a live join has passed: fire with the members that are there.
        Discards messages that lack a required partner, and counts them as unmatched.
        """
        if len(self.members) == 1:
            messages = self.members[0].messages
            if not messages:
                return None
            arrived = messages[0].header.time
            return arrived if not self.sampled else self._sampled_ready(arrived)
        while True:
            time = self._earliest()
            if time is None:
                return None
            if not self._certain(time + self.window):
                if not overdue:
                    return None
                self.in_time = LATE
            if self._all_required(time + self.window):
                return self._sampled_ready(time)
            self._discard(time)

    def take(self, time: int) -> tuple[list[object], list[Message]]:
        """The arguments of the firing at `time` in the order of the ports, and the messages that fired."""
        self.closed = time + self.lateness
        if self.only is not None:
            message = self.only.take()
            return [(message,) if self.ports[0].joined else message], [message]
        arguments: list[object] = []
        fired: list[Message] = []
        limit = time + self.window
        for port in self.ports:
            if port.sampled is not None:
                arguments.append(port.sampled.sample(time))
                continue
            if not (port.members or port.joined):
                arguments.append(None)
                continue
            found = [i.take() for i in port.members if i.messages and i.messages[0].header.time <= limit]
            fired += found
            arguments.append(tuple(found) if port.joined else found[0])
        return arguments, fired

    def watermark(self) -> int:
        """The watermark of the stage: nothing fires earlier than this capture time, ns.

        `END` if the stage will not fire again; `ABSENT` if all inputs that have not ended are absent.
        """
        earliest = END
        for queue in self.members:
            next_at = queue.messages[0].header.time if queue.messages else queue.watermark
            if next_at < earliest:  # cheaper than min()
                earliest = next_at
        return max(earliest, self.closed + 1) if earliest < ABSENT else earliest

    def waiting_since(self) -> int | None:
        """When the oldest message that waits for others entered the graph, ns; None if none waits."""
        return min(
            (queue.messages[0].header.entered for queue in self.members if queue.messages), default=None
        )

    def _earliest(self) -> int | None:
        """Capture time, ns, of the first message after all closed windows; None if there is none."""
        earliest = END
        for queue in self.members:
            if queue.messages and queue.messages[0].header.time <= self.closed:
                queue.discard_until(self.closed, self.in_time)
            if queue.messages and queue.messages[0].header.time < earliest:
                earliest = queue.messages[0].header.time
        return earliest if earliest < END else None

    def _certain(self, limit: int) -> bool:
        """Whether every member has a message, or a watermark beyond `limit`, ns."""
        for queue in self.members:  # noqa: SIM110  # asked for every firing; all() costs twice as much
            if not queue.messages and queue.watermark <= limit:
                return False
        return True

    def _all_required(self, limit: int) -> bool:
        """Whether every required member has a message in the window."""
        for queue in self.required:  # likewise
            if not queue.messages or queue.messages[0].header.time > limit:
                return False
        return True

    def _sampled_ready(self, time: int) -> int | None:
        for sampled in self.sampled:
            if not sampled.ready(time):
                return None
        return time

    def _discard(self, time: int) -> None:
        """Discard the messages of this window: a required partner is missing."""
        for queue in self.members:
            queue.discard_until(time + self.window, UNMATCHED)
        self.closed = time + self.lateness
