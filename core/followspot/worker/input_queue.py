"""The receiving end of an edge: a queue of messages and the bound before which nothing more will come."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from followspot.belonging import Misfit
from followspot.messages import Message
from followspot.transport.edge import PortReader
from followspot.transport.token import ABSENT, END, Invalid, Token, Watermark
from followspot.worker.ledger import DELIVERED, DROPPED, INVALID, UNMATCHED

UNCHANGED = -END
"""As a bound: nothing new is known; who joins goes on waiting."""
_BEFORE_ALL = -END - 1
"""Earlier than any bound: the first firings of a feedback edge wait for nothing."""
_SAMPLED, _AGES = 8, 128
"""The age of each so many messages is noted, and so many ages are kept."""


class InputQueue:
    """One edge as its reader sees it.

    lateness: ns beyond its own time for which a message of this edge promises that nothing else comes,
    0 for a plain source, the window of the join upstream otherwise; wake: marks the reading stage as
    worth a look; reopened: tells a writer in the same worker that a full queue has room again.
    """

    __slots__ = (
        "after_loss",
        "ages",
        "depth",
        "invalid_reason",
        "keep",
        "lateness",
        "messages",
        "missing",
        "name",
        "reader",
        "reopened",
        "row",
        "stale",
        "unfit",
        "wake",
        "watermark",
        "words",
    )

    def __init__(
        self, name: str, words: memoryview, row: int, *, depth: int, lateness: int, keep: int | None = None
    ) -> None:
        """depth: messages with which it is full for its writer.

        keep: messages beyond which the oldest is dropped, None where none is.
        """
        self.name = name
        self.words = words
        self.row = row
        self.depth = depth
        self.keep = keep
        self.lateness = lateness
        self.messages: deque[Message] = deque()
        self.watermark = -END
        self.reader: PortReader | None = None
        self.wake: Callable[[], None] = _nothing
        self.reopened: Callable[[], None] = _nothing
        self.invalid_reason = ""
        self.missing = 0
        """Messages among the invalid ones that were lost on their way."""
        self.after_loss = END
        """The bound when the writer dies: `ABSENT` or `UNCHANGED` where it is started again."""
        self.ages: deque[int] = deque(maxlen=_AGES)
        """How long before they were taken some messages had entered the graph, ns by this host's clock."""
        self.unfit: Misfit | None = None
        """Says why a message from another worker cannot be of the room."""
        self.stale = 0
        """Messages in the queue that a former writer sent; the present one gets no credit for them."""

    def put(self, message: Message) -> None:
        """A message from a stage of the same worker, which counted it; the call is the edge."""
        self.messages.append(message)
        self.watermark = message.header.time + 1 + self.lateness
        self.wake()

    def advance(self, watermark: int) -> None:
        """Nothing earlier than `watermark`, ns, will come."""
        if watermark > self.watermark or self.watermark == ABSENT:
            self.watermark = watermark
            self.wake()

    def poll(self) -> bool:
        """Take over what has arrived from another worker; whether nothing more comes from its reader."""
        assert self.reader is not None
        self._receive(self.reader)
        return self.reader.broken

    def adopt(self, reader: PortReader) -> None:
        """Another writer feeds this edge from now on, after all that the former one sent."""
        assert self.reader is not None
        while self._receive(self.reader):
            pass
        self.reader.close()
        self.reader = reader
        self.stale = len(self.messages)

    def accept(self, token: Token) -> None:
        """One token from another worker; the sender counted it."""
        if isinstance(token, Watermark):
            self.advance(token.time)
        elif isinstance(token, Invalid):
            self.refuse(token.reason)
            self.missing += token.missing
            self.give_credit()
        elif self.unfit is not None and (why := self.unfit(token)):
            self.refuse(why)
            self.give_credit()
        else:
            self.messages.append(token)
            self.watermark = token.header.time + 1 + self.lateness
            self.wake()

    def refuse(self, reason: str) -> None:
        """Count a message that does not match its contract."""
        self.words[self.row + INVALID] += 1
        self.invalid_reason = reason

    def take(self) -> Message:
        """The oldest message, for a firing."""
        count = self.words[self.row + DELIVERED] + 1
        self.words[self.row + DELIVERED] = count
        message = self._pop()
        if count % _SAMPLED == 1:
            self.ages.append(time.monotonic_ns() - message.header.entered)
        return message

    def discard(self, column: int) -> None:
        """Remove the oldest message and count it as dropped, late or unmatched."""
        self.words[self.row + column] += 1
        self._pop()

    def shed(self) -> None:
        """Drop the oldest messages of an edge that keeps only so many."""
        assert self.keep is not None
        while len(self.messages) > self.keep:
            self.discard(DROPPED)

    def discard_until(self, time: int, column: int) -> None:
        """Discard every message captured at or before `time`, ns."""
        while self.messages and self.messages[0].header.time <= time:
            self.discard(column)

    def clear(self) -> None:
        """Discard what nobody will ask for any more: the reading stage has ended."""
        while self.messages:
            self.discard(UNMATCHED)

    def give_credit(self) -> None:
        """Let the sender in another worker send one more."""
        if self.reader is not None:
            self.reader.consumed()

    def _receive(self, reader: PortReader) -> bool:
        """Take over what the reader has, which may be a part of what has arrived; whether it had anything."""
        tokens = reader.poll()
        for token in tokens:
            self.accept(token)
        if reader.lost:
            self.advance(self.after_loss)
        return bool(tokens)

    def _pop(self) -> Message:
        message = self.messages.popleft()
        if self.stale:
            self.stale -= 1
        elif self.reader is not None:
            self.reader.consumed()
        elif len(self.messages) == self.depth - 1:
            self.reopened()
        return message


class SampledInput:
    """An input that is sampled at a firing and never fires: `Latest`, or a feedback edge with `delay`."""

    __slots__ = ("delay", "past", "queue", "sampled", "timed")

    def __init__(self, queue: InputQueue, *, delay: int, timed: bool, initial: Message | None) -> None:
        """delay: firings back, 0 for `Latest`; timed: sample by capture time, not by arrival."""
        self.queue = queue
        self.delay = delay
        self.timed = timed
        self.sampled = initial
        self.past: deque[int] = deque([_BEFORE_ALL] * delay, maxlen=max(1, delay))

    def ready(self, time: int) -> bool:
        """Whether the sample for a firing at `time`, ns, is certain."""
        return not self.timed or self.queue.watermark > self._due(time)

    def sample(self, time: int) -> Message | None:
        """The newest message due at a firing at `time`; older ones that no firing saw count as dropped."""
        messages = self.queue.messages
        due = self._due(time) if self.timed else END
        while messages and messages[0].header.time <= due:
            if len(messages) > 1 and messages[1].header.time <= due:
                self.queue.discard(DROPPED)
            else:
                self.sampled = self.queue.take()
        if self.delay:
            self.past.append(time)
        return self.sampled

    def _due(self, time: int) -> int:
        """Capture time up to which messages count: of this firing, or of the one `delay` firings ago."""
        return self.past[0] if self.delay else time


def _nothing() -> None:
    """An end that nobody watches."""
