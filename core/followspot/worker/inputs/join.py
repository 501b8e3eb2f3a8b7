"""When a stage fires: the join of its inputs by capture time and watermark.

A join begins with the earliest message. It is complete when every member (input queue that is joined) has a
message in the window, or a watermark beyond the window. A member whose messages follow each other faster than
the window gives the message nearest to the join; the join waits until that message is known. The rule
depends on the streams only and on no clock, so the same messages fire together in any placement. Only the
deadline of a live join depends on the time.
"""

from __future__ import annotations

from collections.abc import Sequence

from followspot.messages import Message
from followspot.ports.specs import InputSpec
from followspot.transport.token import ABSENT, END
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.inputs.join_input import JoinInput, rearranged, with_former_samples
from followspot.worker.ledger import LATE, UNMATCHED


class Join:
    """The inputs of one stage.

    lateness: ns after a firing's time within which nothing else fires (the window, plus the lateness of the
    inputs); lag: see :meth:`relieve_backpressure`, None in a live run, where full edges drop.
    """

    def __init__(self, ports: Sequence[JoinInput], *, lateness: int, lag: int | None = None) -> None:
        self.ports = tuple(ports)
        self.members = tuple(queue for port in ports for queue in port.members)
        self.sampled = tuple(port.sampled for port in ports if port.sampled is not None)
        self.required = tuple(queue for port in ports if not port.joined for queue in port.members)
        self.free = tuple(queue for queue in self.members if not queue.answers)
        """Members that do not depend on what the stage gives."""
        self.dropping = tuple(queue for queue in self.members if queue.keep is not None)
        """Members that keep only their newest messages."""
        self.only = self.members[0] if len(self.members) == len(self.ports) == 1 else None
        """The only member of a stage with one input, the commonest: it fires for each message as it comes."""
        self.lateness = lateness
        self.lag = lag
        self.closed = -END - 1
        """Capture time, ns, up to which everything was fired or discarded; before all times at first."""
        self.in_time = UNMATCHED
        """Ledger column of messages whose window is closed: `LATE` once a deadline has closed one."""
        self._first_window = 0
        """Window, ns, of the member with the earliest message."""

    def read_by(self, inputs: Sequence[InputSpec]) -> Join:
        """The same join for another stage that declares these ports; see `rearranged`."""
        join = Join(tuple(rearranged(self.ports, inputs)), lateness=self.lateness, lag=self.lag)
        join._resume(self)
        return join

    def carry_on(self, former: Join) -> None:
        """Go on from where the former join of the stage is; sampled inputs of the same edges stay."""
        self._resume(former)
        self.ports = tuple(with_former_samples(self.ports, former.ports))
        self.sampled = tuple(port.sampled for port in self.ports if port.sampled is not None)

    def ready(self, *, overdue: bool = False) -> int | None:
        """Capture time, ns, of the next firing, or None while it is not certain.

        overdue: the deadline of a live join has passed: fire with the members that are there.
        Discards messages that lack a required partner, and counts them as unmatched.
        """
        if len(self.members) == 1:
            messages = self.members[0].messages
            if not messages:
                return None
            time = messages[0].header.time
            return self._sampled_ready(time, overdue) if self.sampled else time
        while True:
            first = self._first()
            if first is None:
                return None
            time = first.messages[0].header.time
            self._first_window = first.window
            if not self._all_known(time):
                if not overdue:
                    return None
                self.in_time = LATE
                if not self._all_required(time):
                    self._close(time)
                    continue
            elif not self._all_required(time):
                first.discard(UNMATCHED)
                continue
            early = self._not_nearest(time)
            if early is None or (overdue and len(early.messages) == 1):
                return self._sampled_ready(time, overdue)
            if len(early.messages) == 1:
                return None
            early.discard(UNMATCHED)

    def take(self, time: int) -> tuple[list[object], list[Message]]:
        """The arguments of the firing at `time` in the order of the ports, and the messages that fired."""
        self.closed = time + self.lateness
        if self.only is not None:
            message = self.only.take()
            return [(message,) if self.ports[0].joined else message], [message]
        arguments: list[object] = []
        fired: list[Message] = []
        for port in self.ports:
            if port.sampled is not None:
                arguments.append(port.sampled.sample(time))
                continue
            if not (port.members or port.joined):
                arguments.append(None)
                continue
            found = self._take_first(port.members, time)
            fired += found
            arguments.append(tuple(found) if port.joined else found[0])
        return arguments, fired

    def gives(self, queue: InputQueue, time: int) -> bool:
        """Whether a member gives its first message to the firing at this time, ns; ask before `take`."""
        return queue is self.only or self._in_window(queue, time)

    def relieve_backpressure(self, earliest: int) -> None:
        """Exempt messages on full edges from the depth, so that a replay cannot deadlock.

        If the stage waits for one input, the senders of its other inputs must be able to go on: the awaited
        input may depend on them. So messages up to the next possible firing do not count against the depth,
        nor do messages up to `lag`, ns, later. `lag` is the longest time by which streams of the graph may
        trail each other: the largest sum, along any path, of the times that joins look ahead.

        Why that is enough, whatever the rates and depths: consider the source furthest behind among those
        that full edges block. It would have to wait for a source that is even further behind.

        earliest: :meth:`watermark`, ns.
        """
        if self.only is not None or self.lag is None:
            return
        for sampled in self.sampled:
            sampled.relieve_backpressure(earliest, self.lag)
        for queue in self.members:
            if len(queue.messages) >= queue.depth:
                queue.exempt(earliest + self.lag)

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

    def _resume(self, former: Join) -> None:
        self.closed, self.in_time, self._first_window = former.closed, former.in_time, former._first_window

    def _first(self) -> InputQueue | None:
        """The member with the earliest message after all closed windows; None if there is none."""
        first, earliest = None, END
        for queue in self.members:
            if queue.messages and queue.messages[0].header.time <= self.closed:
                queue.discard_until(self.closed, self.in_time)
            if queue.messages and queue.messages[0].header.time < earliest:
                first, earliest = queue, queue.messages[0].header.time
        return first

    def _all_known(self, time: int) -> bool:
        """Whether every member has a message, or a watermark beyond its window that begins at `time`, ns."""
        first_window = self._first_window
        for queue in self.members:  # asked for every firing; all() costs twice as much
            if not queue.messages:
                window = queue.window
                if queue.watermark <= time + (window if window > first_window else first_window):
                    return False
        return True

    def _all_required(self, time: int) -> bool:
        """Whether every required member has a message in its window that begins at `time`, ns."""
        for queue in self.required:  # noqa: SIM110  # likewise
            if not self._in_window(queue, time):
                return False
        return True

    def _in_window(self, queue: InputQueue, time: int) -> bool:
        """Whether a member has a message in its window that begins at `time`, ns."""
        window, first_window = queue.window, self._first_window
        limit = time + (window if window > first_window else first_window)
        return bool(queue.messages) and queue.messages[0].header.time <= limit

    def _not_nearest(self, time: int) -> InputQueue | None:
        """A member whose second message is, or may be, nearer to the join than its first; None if no such.

        The time of the join is that of the latest first message. A second message can only be nearer if it
        follows the first within twice the window. So the join does not wait for a member whose last two
        messages lie further apart, nor for one that depends on the result of this firing.
        """
        if not self._any_frequent():
            return None
        heads = [(q.messages[0].header.time, q) for q in self.members if self._in_window(q, time)]
        pivot = max([head for head, _ in heads])
        for head, queue in heads:
            window = max(queue.window, self._first_window)
            if queue.answers or head == pivot or head - queue.left_at > 2 * window:
                continue
            if len(queue.messages) == 1:
                if queue.watermark < 2 * pivot - head:
                    return queue
            elif abs((following := queue.messages[1].header.time) - pivot) < pivot - head:
                others = min([other for other, member in heads if member is not queue])
                if following - others <= window:
                    return queue
        return None

    def _any_frequent(self) -> bool:
        """Whether any member sends so often that its second message may be nearer to the join; few do."""
        first_window = self._first_window
        for queue in self.free:
            if queue.messages:
                window = queue.window if queue.window > first_window else first_window
                if queue.messages[0].header.time - queue.left_at <= 2 * window:
                    return True
        return False

    def _sampled_ready(self, time: int, overdue: bool) -> int | None:
        for sampled in self.sampled:
            if not sampled.ready(time) and (sampled.outlasts_deadline or not overdue):
                return None
        return time

    def _close(self, time: int) -> None:
        """Discard the messages of this window: a required partner did not come before the deadline."""
        for queue in self.members:
            queue.discard_until(time + max(queue.window, self._first_window), UNMATCHED)
        self.closed = time + self.lateness

    def _take_first(self, members: Sequence[InputQueue], time: int) -> list[Message]:
        """The first message of each member with a message in its window that begins at `time`, ns."""
        first_window, found = self._first_window, []
        for queue in members:
            if queue.messages:
                head, window = queue.messages[0].header.time, queue.window
                if head <= time + (window if window > first_window else first_window):
                    found.append(queue.take())
                    queue.left_at = head
        return found
