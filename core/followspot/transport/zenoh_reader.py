"""The reading end of an edge over Zenoh (docs/wire.md).

Zenoh's threads only append to a queue and ring a bell; all else happens in the worker's thread.
"""

from __future__ import annotations

import contextlib
from collections import deque
from urllib.parse import quote

import zenoh
from zenoh.handlers import Callback

from followspot.messages import InvalidMessage, Message
from followspot.transport.bell import Bell
from followspot.transport.codec import MAX_PACKED, unpack
from followspot.transport.token import END, Invalid, Settled, Token
from followspot.transport.zenoh_terms import CREDIT, NUMBER, WINDOW, presence, publisher, reached, undeclare


class ZenohReader:
    """`PortReader` of a `ZenohWriter`."""

    def __init__(self, session: zenoh.Session, key: str, name: str, kind: type[Message], depth: int) -> None:
        """key, name, depth: as the writer knows them; kind: type of the messages."""
        self._kind = kind
        self._limit = depth + WINDOW
        self._arrived: deque[zenoh.Sample] = deque()
        self._tokens = 0
        self._messages = 0
        self._consumed = 0
        self._reported = 0
        self._ended = False
        self._writer = False
        self._gone = False
        self._bell = Bell()
        name = quote(name, safe="")
        self._session = session
        self._done_key = f"{key}/alive/done/{name}"
        self._report = publisher(session, f"{key}/credit/{name}")
        self._declared = [
            session.declare_subscriber(key, Callback(self._on_arrival, indirect=False)),
            presence(session, f"{key}/alive/writer", self._on_presence),
            session.liveliness().declare_token(f"{key}/alive/reader/{name}"),
        ]

    @property
    def lost(self) -> bool:
        """Whether the writer was there and is gone without an end."""
        return self._gone and not self._ended and not self._arrived

    def matched(self) -> bool:
        """Whether the writer is there, and would get reports."""
        return self._writer and reached(self._report)

    def fileno(self) -> int:
        """The bell."""
        return self._bell.fileno()

    def poll(self) -> list[Token]:
        """Everything that has arrived."""
        self._bell.hush()
        tokens: list[Token] = []
        for _ in range(len(self._arrived)):
            self._take(self._arrived.popleft(), tokens)
        if self._tokens - self._reported >= WINDOW // 4:
            self._send_report()
        return tokens

    def consumed(self, count: int = 1) -> None:
        """Give credit for messages that were taken out of the queue."""
        self._consumed += count
        self._send_report()

    def close(self) -> None:
        """Undeclare everything; the session stays open."""
        undeclare([*reversed(self._declared), self._report])
        self._bell.close()

    def _take(self, sample: zenoh.Sample, tokens: list[Token]) -> None:
        """Append the sample's token, and before it an `Invalid` for each message that is missing.

        What does not carry on the numbers comes from a stranger; no ledger knows it, so it is passed over.
        """
        attachment = b"" if sample.attachment is None else sample.attachment.to_bytes()
        if len(attachment) != NUMBER.size:
            return
        number, messages = NUMBER.unpack(attachment)
        skipped = number - self._tokens
        new = messages - self._messages
        if not 0 <= skipped <= self._limit or not 0 <= new <= skipped + 1:
            return
        token = self._token(sample)
        missing = new - (not isinstance(token, Settled))
        if missing < 0:
            return
        self._tokens, self._messages = number + 1, messages
        tokens += [Invalid(f"gap: it is one of {missing} messages that never came")] * missing
        tokens.append(token)

    def _token(self, sample: zenoh.Sample) -> Token:
        if len(sample.payload) > MAX_PACKED:
            return Invalid(f"{len(sample.payload)} bytes, at most {MAX_PACKED} allowed")
        try:
            token = unpack(sample.payload.to_bytes(), self._kind)
        except InvalidMessage as error:
            return Invalid(str(error))
        if not self._ended and isinstance(token, Settled) and token.bound == END:
            self._ended = True
            self._declare_done()
        return token

    def _declare_done(self) -> None:
        """Tell the writer that the end is here, in a way that the news of leaving cannot overtake."""
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._declared.insert(0, self._session.liveliness().declare_token(self._done_key))

    def _send_report(self) -> None:
        self._reported = self._tokens
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._report.put(CREDIT.pack(self._consumed, self._tokens))

    def _on_arrival(self, sample: zenoh.Sample) -> None:
        if len(self._arrived) < self._limit:  # a flood from a stranger; the numbers show what is missing
            self._arrived.append(sample)
        self._bell.ring()

    def _on_presence(self, sample: zenoh.Sample) -> None:
        self._writer = sample.kind == zenoh.SampleKind.PUT
        self._gone = not self._writer
        self._bell.ring()
