"""The receiving end of an edge: a queue of messages and the edge's watermark."""

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
"""A watermark that is never news: the reading stage goes on waiting."""
_BEFORE_ALL = -END - 1
"""Earlier than any watermark: the first firings with a feedback edge wait for nothing."""
_EVERY, _AGES = 8, 128
"""Every eighth message has its age noted; the newest 128 ages are kept."""


class InputQueue:
    """One edge as its reader sees it.

    lateness: ns after its own time within which a message of this edge announces that nothing else comes, 0
    for a plain source, else the windows of the joins upstream; wake: schedules the reading stage; reopened:
    schedules a writer in the same worker when a full queue has room again.
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
        """words, row: the edge's counts in the ledger; depth: messages with which the queue is full.

        keep: messages beyond which the oldest is dropped, None to drop none.
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
        self.wake: Callable[[], None] = lambda: None
        self.reopened: Callable[[], None] = lambda: None
        self.invalid_reason = ""
        self.missing = 0
        """Messages among the invalid ones that were lost on their way."""
        self.after_loss = END
        """The watermark when the writer dies: `ABSENT` or `UNCHANGED` if it is started again."""
        self.ages: deque[int] = deque(maxlen=_AGES)
        """Ages of some messages when they were taken, ns since they entered the graph."""
        self.unfit: Misfit | None = None
        """Says why a message from another worker does not fit the room."""
        self.stale = 0
        """Messages in the queue from a former writer: the present one gets no credit for them."""

    def put(self, message: Message) -> None:
        """Take a message from a stage of the same worker, which counted it."""
        self.messages.append(message)
        self.watermark = message.header.time + 1 + self.lateness
        self.wake()

    def advance(self, watermark: int) -> None:
        """Advance the watermark to `watermark`, ns: nothing earlier will come."""
        if watermark > self.watermark or self.watermark == ABSENT:
            self.watermark = watermark
            self.wake()

    def poll(self) -> bool:
        """Take what has arrived from another worker; whether the reader is broken."""
        assert self.reader is not None
        self._receive(self.reader)
        return self.reader.broken

    def adopt(self, reader: PortReader) -> None:
        """Read from another writer from now on, after everything that the former one sent."""
        assert self.reader is not None
        while self._receive(self.reader):
            pass
        self.reader.close()
        self.reader = reader
        self.stale = len(self.messages)

    def accept(self, token: Token) -> None:
        """Take one token from another worker, which counted it."""
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
        """Count a message that breaks its contract as invalid."""
        self.words[self.row + INVALID] += 1
        self.invalid_reason = reason

    def take(self) -> Message:
        """The oldest message, for a firing."""
        count = self.words[self.row + DELIVERED] + 1
        self.words[self.row + DELIVERED] = count
        message = self._pop()
        if count % _EVERY == 1:
            self.ages.append(time.monotonic_ns() - message.header.entered)
        return message

    def discard(self, column: int) -> None:
        """Remove the oldest message and count it as dropped, late or unmatched."""
        self.words[self.row + column] += 1
        self._pop()

    def shed(self) -> None:
        """Drop the oldest messages beyond those that the edge keeps."""
        assert self.keep is not None
        while len(self.messages) > self.keep:
            self.discard(DROPPED)

    def discard_until(self, time: int, column: int) -> None:
        """Discard every message captured at or before `time`, ns."""
        while self.messages and self.messages[0].header.time <= time:
            self.discard(column)

    def clear(self) -> None:
        """Discard all messages: the reading stage has ended."""
        while self.messages:
            self.discard(UNMATCHED)

    def give_credit(self) -> None:
        """Give the writer in another worker credit for one more message."""
        if self.reader is not None:
            self.reader.consumed()

    def _receive(self, reader: PortReader) -> bool:
        """Take what the reader gives at once; whether it gave anything."""
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
    """A sampled input, which never fires: `Latest`, or a feedback edge with `delay`."""

    __slots__ = ("delay", "past", "queue", "sampled", "timed")

    def __init__(self, queue: InputQueue, *, delay: int, timed: bool, initial: Message | None) -> None:
        """delay: firings back, 0 for `Latest`; timed: sample by capture time, not by arrival."""
        self.queue = queue
        self.delay = delay
        self.timed = timed
        self.sampled = initial
        self.past: deque[int] = deque([_BEFORE_ALL] * delay, maxlen=max(1, delay))

    def ready(self, time: int) -> bool:
        """Whether the sample for a firing at `time`, ns, is certain: the watermark has passed it."""
        return not self.timed or self.queue.watermark > self._due(time)

    def sample(self, time: int) -> Message | None:
        """The newest message up to the firing at `time`, ns; older ones without a firing count as dropped."""
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
        """Latest capture time, ns, to sample: of this firing, or of the one `delay` firings ago."""
        return self.past[0] if self.delay else time
