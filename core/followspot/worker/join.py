"""When a stage fires: the join of its inputs by capture time and watermark.

A join is complete when every member either has a message in the window or is known to have none. The rule
reads the streams alone, never the clock of the wall, so any placement fires the same messages together;
only the deadline of a live join looks at the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from followspot.messages import Message
from followspot.ports import InputSpec
from followspot.transport.token import ABSENT, END
from followspot.worker.input_queue import InputQueue, SampledInput
from followspot.worker.ledger import LATE, UNMATCHED


@dataclass(frozen=True)
class JoinInput:
    """One parameter of `process` and the edges that feed it: members of the join, or one held edge.

    An optional input that nothing is connected to has neither; it gets None.
    """

    name: str
    joined: bool
    members: tuple[InputQueue, ...] = ()
    sampled: SampledInput | None = None


class Join:
    """The inputs of one stage.

    window: largest difference in capture time between members, ns; lateness: ns after a firing's time within
    which nothing else fires (the window, and what the inputs themselves promise).
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
        """Capture time, ns, up to which everything was fired or given up; before any at first."""
        self.in_time = UNMATCHED
        """Column for messages that come after their window closed; `LATE` once a deadline closed one."""

    def read_by(self, inputs: Sequence[InputSpec]) -> Join:
        """The same inputs for a stage with these ports, which may stand in another order."""
        known = {port.name: port for port in self.ports}
        arranged = [known.get(p.name) or JoinInput(p.name, joined=p.kind == "joined") for p in inputs]
        join = Join(arranged, window=self.window, lateness=self.lateness)
        join.closed, join.in_time = self.closed, self.in_time
        return join

    def ready(self, *, overdue: bool = False) -> int | None:
        """Capture time, ns, of the next firing, or None while it is not certain.

        overdue: the deadline of a live join has passed; fire with what is there.
        Messages that lack a required partner are counted as unmatched and removed on the way.
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
            self._give_up(time)

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
        """Nothing fires earlier than this capture time, ns.

        `END` when the stage will not fire again; `ABSENT` when all that could still come is away.
        """
        earliest = END
        for queue in self.members:
            next_at = queue.messages[0].header.time if queue.messages else queue.watermark
            if next_at < earliest:  # cheaper than min()
                earliest = next_at
        return max(earliest, self.closed + 1) if earliest < ABSENT else earliest

    def waiting_since(self) -> int | None:
        """When the oldest message that waits for others entered the graph, ns; None where none waits."""
        return min(
            (queue.messages[0].header.entered for queue in self.members if queue.messages), default=None
        )

    def _earliest(self) -> int | None:
        """Time of the first message that no closed window claims, ns."""
        earliest = END
        for queue in self.members:
            if queue.messages and queue.messages[0].header.time <= self.closed:
                queue.discard_until(self.closed, self.in_time)
            if queue.messages and queue.messages[0].header.time < earliest:
                earliest = queue.messages[0].header.time
        return earliest if earliest < END else None

    def _certain(self, limit: int) -> bool:
        """Whether every member has its message, or is known to have none up to `limit`."""
        for queue in self.members:  # noqa: SIM110  # asked for every firing; all() costs twice as much
            if not queue.messages and queue.watermark <= limit:
                return False
        return True

    def _all_required(self, limit: int) -> bool:
        """Whether every member that cannot be missed has a message in the window."""
        for queue in self.required:  # likewise
            if not queue.messages or queue.messages[0].header.time > limit:
                return False
        return True

    def _sampled_ready(self, time: int) -> int | None:
        for sampled in self.sampled:
            if not sampled.ready(time):
                return None
        return time

    def _give_up(self, time: int) -> None:
        """A required partner is missing: what is there at this time has no match."""
        for queue in self.members:
            queue.discard_until(time + self.window, UNMATCHED)
        self.closed = time + self.lateness
