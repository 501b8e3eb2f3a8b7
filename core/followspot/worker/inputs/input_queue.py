"""The receiving end of an edge: a queue of messages and the edge's watermark."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from followspot.message_checks.room_fit import FitCheck
from followspot.messages import Message
from followspot.transport.edge import PortReader
from followspot.transport.token import ABSENT, END, Invalid, Token, Watermark
from followspot.worker.ledger import DELIVERED, DROPPED, INVALID, UNMATCHED

UNCHANGED = -END
"""A watermark that never advances the watermark of an edge, so the reading stage goes on waiting."""
_BEFORE_ALL = -END
"""Earlier than any capture time."""
_EVERY, _AGES = 8, 128
"""Every eighth message has its age noted; the newest 128 ages are kept."""


class InputQueue:
    """One edge as its reader sees it.

    lateness: a message announces that no other message of this edge has a capture time up to its own plus
    this time, ns; 0 for a plain source, else the sum of the windows of the joins upstream; wake: schedules
    the reading stage; reopened: schedules a writer in the same worker when a full queue has room again.
    """

    __slots__ = (
        "after_loss",
        "ages",
        "answers",
        "depth",
        "invalid_reason",
        "keep",
        "lateness",
        "left_at",
        "messages",
        "missing",
        "name",
        "reader",
        "received",
        "reopened",
        "row",
        "uncredited",
        "unfit",
        "wake",
        "watermark",
        "window",
        "words",
    )

    def __init__(
        self,
        name: str,
        words: memoryview,
        row: int,
        *,
        depth: int,
        lateness: int,
        keep: int | None = None,
        window: int = 0,
    ) -> None:
        """words, row: the edge's counts in the ledger; depth: number of messages of a full queue.

        keep: number of messages beyond which the oldest is dropped, None to drop none; window: how much later
        than the first message of a join a message of this edge may be, ns.
        """
        self.name = name
        self.words = words
        self.row = row
        self.depth = depth
        self.keep = keep
        self.lateness = lateness
        self.window = window
        self.answers = False
        """Whether messages may depend on outputs of the reading stage, which then must not wait for more."""
        self.left_at = _BEFORE_ALL
        """Capture time, ns, of the newest message that a join took or discarded."""
        self.messages: deque[Message] = deque()
        self.watermark = -END
        self.reader: PortReader | None = None
        self.received = 0
        """Messages and watermarks that came from another worker."""
        self.wake: Callable[[], None] = lambda: None
        self.reopened: Callable[[], None] = lambda: None
        self.invalid_reason = ""
        self.missing = 0
        """Messages among the invalid ones that were lost on their way."""
        self.after_loss = END
        """The watermark when the writer dies: `ABSENT` or `UNCHANGED` if it is started again."""
        self.ages: deque[int] = deque(maxlen=_AGES)
        """Ages of some messages when they were taken, ns since they entered the graph."""
        self.unfit: FitCheck | None = None
        """Says why a message from another worker does not fit the room."""
        self.uncredited = 0
        """How many of the oldest messages give the writer no credit when they leave: they were exempt, or
        came from a former writer."""

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
        """Take the messages that have arrived from another worker; returns whether the reader is broken."""
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
        self.uncredited = len(self.messages)

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
        words, at = self.words, self.row + DELIVERED
        words[at] = count = words[at] + 1
        message = self._pop()
        if count % _EVERY == 1:
            self.ages.append(time.monotonic_ns() - message.header.entered)
        return message

    def discard(self, column: int) -> None:
        """Remove the oldest message and count it as dropped, late or unmatched."""
        self.words[self.row + column] += 1
        self.left_at = self._pop().header.time

    def supersede(self, time: int) -> None:
        """Drop all messages captured up to `time`, ns, but the newest of these."""
        messages = self.messages
        while len(messages) > 1 and messages[1].header.time <= time:
            self.discard(DROPPED)

    def exempt(self, time: int) -> None:
        """Exempt the messages captured up to `time`, ns, from the depth: the sender may go on beyond them."""
        before = self.uncredited
        while self.uncredited < len(self.messages) and self.messages[self.uncredited].header.time <= time:
            self.uncredited += 1
        exempted = self.uncredited - before
        if self.reader is None:
            self.depth += exempted
            if exempted:
                self.reopened()
        elif exempted:
            self.reader.consumed(exempted)

    def drop_oldest(self) -> None:
        """Drop the oldest messages beyond those that the edge keeps."""
        assert self.keep is not None
        while len(self.messages) > self.keep:
            self.discard(DROPPED)

    def discard_until(self, time: int, column: int) -> None:
        """Discard every message captured at or before `time`, ns."""
        while self.messages and self.messages[0].header.time <= time:
            self.discard(column)

    def clear(self, column: int = UNMATCHED) -> None:
        """Discard all messages: the reading stage has ended."""
        while self.messages:
            self.discard(column)

    def give_credit(self) -> None:
        """Give the writer in another worker credit for one more message."""
        if self.reader is not None:
            self.reader.consumed()

    def _receive(self, reader: PortReader) -> bool:
        """Take the messages that the reader has at once; returns whether there were any."""
        tokens = reader.poll()
        self.received += len(tokens)
        for token in tokens:
            self.accept(token)
        if reader.lost:
            self.advance(self.after_loss)
        return bool(tokens)

    def _pop(self) -> Message:
        message = self.messages.popleft()
        if self.uncredited:
            self.uncredited -= 1
            if self.reader is None:
                self.depth -= 1
        elif self.reader is not None:
            self.reader.consumed()
        elif len(self.messages) == self.depth - 1:
            self.reopened()
        return message
