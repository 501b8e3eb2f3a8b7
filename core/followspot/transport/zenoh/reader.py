"""The reading end of an edge over Zenoh (docs/wire.md).

Zenoh's threads only append to a queue and set the wake-up event; the worker's thread does all else.
"""

from __future__ import annotations

import contextlib
from collections import deque
from urllib.parse import quote

import zenoh
from zenoh.handlers import Callback

from followspot.graph.plan import EdgeCodec
from followspot.messages import InvalidMessage, Message
from followspot.transport.codec import MAX_PACKED
from followspot.transport.keys import reader_key
from followspot.transport.token import END, UNKNOWN, Invalid, Token, Watermark
from followspot.transport.wakeup_event import WakeupEvent
from followspot.transport.zenoh.codec import unpack_as
from followspot.transport.zenoh.stream_position import StreamPosition
from followspot.transport.zenoh.terms import (
    CREDIT,
    START,
    WINDOW,
    attached,
    chunks,
    codec_key,
    has_subscriber,
    is_incarnation,
    numbers,
    presence,
    publisher,
    undeclare,
)

_SELDOM = WINDOW // 4
"""Watermarks after which a reader that has consumed nothing reports."""


class ZenohReader:
    """`PortReader` of a `ZenohWriter`, and of the writers that replace it when it dies."""

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        name: str,
        kind: type[Message],
        depth: int,
        *,
        codec: EdgeCodec = "raw",
        host: str = "",
        incarnation: int = 0,
    ) -> None:
        """key, name, depth, codec, host: equal to those of the writer; kind: type of the messages.

        incarnation: how many readers of this name there were before.
        """
        self._kind = kind
        self._limit = depth + WINDOW
        self._incarnation = incarnation
        self._arrived: deque[zenoh.Sample | int] = deque()
        """Samples in order of arrival; a number is the incarnation of a writer that left."""
        self._before: list[Token] = []
        """Tokens for the first poll: messages that were missing when the writer told the start."""
        self.position = StreamPosition(self._limit)
        self._reported = 0
        self._report_after = _SELDOM
        self._ended = False
        self._refused = self._flooded = self._floods_seen = 0
        self._there: set[int] = set()
        self._newest = -1
        """Latest incarnation of a writer that is there, whether or not it has told a start."""
        self._gone = incarnation > 0
        self._wakeup = WakeupEvent()
        key = codec_key(key, codec)
        name = quote(name, safe="")
        self._session = session
        self._start_key = f"{key}/start/{name}/{incarnation}"
        own_key = reader_key(key, host)
        self._done_key = f"{own_key}/done/{name}/{incarnation}"
        self._report = publisher(session, f"{own_key}/credit/{name}")
        self._declared = [
            session.declare_subscriber(key, Callback(self._on_arrival, indirect=False)),
            session.declare_subscriber(self._start_key, Callback(self._on_arrival, indirect=False)),
            presence(session, f"{key}/alive/writer/*", self._on_presence),
        ]
        self._alive_key = f"{own_key}/alive/{name}/{incarnation}"
        self._alive = session.liveliness().declare_token(self._alive_key)

    @property
    def lost(self) -> bool:
        """Whether the writer was there and is gone without an end."""
        return self._gone and not (self._ended or self._arrived or self._before)

    @property
    def rejected(self) -> int:
        """How much came that was malformed or not from the writer; no ledger counts it."""
        return self._refused + self.position.refused + self._flooded

    @property
    def broken(self) -> bool:
        """False: another writer may come."""
        return False

    def matched(self) -> bool:
        """Whether the writer is there, has told the start, and would get reports."""
        self._begin()
        if self.position.writer < 0 or not has_subscriber(self._report):
            return False
        self._send_report()  # an earlier one may have been lost
        return True

    @property
    def caught_up(self) -> bool:
        """True: only the writer can know."""
        return True

    def report_at_once(self, at_once: bool) -> None:
        """See `PortReader.report_at_once`."""
        self._report_after = 1 if at_once else _SELDOM
        self._send_report()

    def fileno(self) -> int:
        """The wake-up event."""
        return self._wakeup.fileno()

    def poll(self) -> list[Token]:
        """All tokens that have arrived."""
        self._wakeup.clear()
        tokens, self._before = self._before, []
        for _ in range(len(self._arrived)):
            self._take(self._arrived.popleft(), tokens)
        if self.position.tokens - self._reported >= self._report_after:
            self._send_report()
        if self._flooded != self._floods_seen:
            self._floods_seen = self._flooded
            self._rejoin()
        return tokens

    def consumed(self, count: int = 1) -> None:
        """Give credit for messages that left the queue."""
        self.position.consume(count)
        self._send_report()

    def close(self) -> None:
        """Undeclare everything; the session stays open."""
        undeclare([self._alive, *reversed(self._declared), self._report])
        self._wakeup.close()

    def _rejoin(self) -> None:
        """Join again, as after a cut: tokens of the writer may be among those that a flood left out."""
        self.position.joined = False
        undeclare([self._alive])
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._alive = self._session.liveliness().declare_token(self._alive_key)

    def _begin(self) -> None:
        """Before the first token, take the start if the writer has told it."""
        while self.position.writer < 0 and self._arrived:
            self._take(self._arrived.popleft(), self._before)

    def _start(self, sample: zenoh.Sample, tokens: list[Token]) -> None:
        """Take the start that a writer tells: of its stream, or of the rest after the link was cut."""
        before = self.position.writer
        missing = self.position.start(numbers(START, sample.payload), self._newest)
        if missing is None:
            return
        self._ended &= self.position.writer == before
        tokens += [Invalid("gap: it was on its way when the link was cut", missing=True)] * missing
        self._send_report()

    def _take(self, sample: zenoh.Sample | int, tokens: list[Token]) -> None:
        """Append the sample's token, and before it an `Invalid` for each message that is missing.

        A sample whose numbers do not follow is not from the writer, and is refused; no ledger counts it.
        """
        if isinstance(sample, int):
            self.position.left(sample)
            return
        if str(sample.key_expr) == self._start_key:
            self._start(sample, tokens)
            return
        counted, watermark = attached(sample.attachment) or (None, UNKNOWN)
        if counted is None or not self.position.follows(counted):
            self.position.refused += counted is None
            return
        token = self._token(sample)
        missing = self.position.advance(counted, message=not isinstance(token, Watermark))
        if missing is None:
            return
        tokens += [Invalid(f"gap: it is one of {missing} messages that never came", missing=True)] * missing
        tokens.append(token)
        if watermark != UNKNOWN:
            tokens.append(Watermark(watermark))

    def _token(self, sample: zenoh.Sample) -> Token:
        """The token of a sample, or an `Invalid` in its place."""
        if len(sample.payload) > MAX_PACKED:
            return Invalid(f"{len(sample.payload)} bytes, at most {MAX_PACKED} allowed")
        try:
            token = unpack_as(sample.payload.to_bytes(), self._kind)
        except InvalidMessage as error:
            return Invalid(str(error))
        if not self._ended and isinstance(token, Watermark) and token.time == END:
            self._ended = True
            self._declare_done()
        return token

    def _declare_done(self) -> None:
        """Tell the writer that the end has arrived: by a liveliness token, which precedes that of leaving."""
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            done = self._session.liveliness().declare_token(f"{self._done_key}/{self.position.writer}")
            self._declared.insert(0, done)

    def _send_report(self) -> None:
        """Report the consumed and taken messages, in the writer's numbers."""
        position = self.position
        self._reported = position.tokens
        if position.writer < 0:
            return
        report = CREDIT.pack(position.writer, self._incarnation, position.consumed, position.tokens)
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._report.put(report)

    def _on_arrival(self, sample: zenoh.Sample) -> None:
        """Queue a sample, in a thread of Zenoh."""
        if len(self._arrived) < self._limit:  # else it is a flood; the numbers show what is missing
            self._arrived.append(sample)
        else:
            self._flooded += 1
        self._wakeup.set()

    def _on_presence(self, sample: zenoh.Sample) -> None:
        """Note that a writer came or left, in a thread of Zenoh."""
        incarnation = chunks(sample, 1)[0]
        if not is_incarnation(incarnation):
            self._refused += 1
            return
        number = int(incarnation)
        if sample.kind == zenoh.SampleKind.PUT:
            self._there.add(number)
        else:
            self._there.discard(number)
            self._arrived.append(number)
        self._newest = max(self._there, default=-1)
        self._gone = max(self._newest, self.position.writer) not in self._there
        self._wakeup.set()
