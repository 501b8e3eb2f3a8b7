"""Edges over Zenoh, between hosts (docs/wire.md).

Zenoh loses nothing between living peers as long as nobody floods it, so credit bounds what is under way.
Its threads only append to a queue and ring a bell; all else happens in the worker's thread.
"""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Iterable, Sequence
from struct import Struct
from typing import Any
from urllib.parse import quote

import numpy as np
import zenoh
from zenoh.handlers import Callback

from followspot.messages import Array, InvalidMessage, Message
from followspot.transport.bell import Bell
from followspot.transport.codec import MAX_PACKED, pack, unpack
from followspot.transport.token import END, Invalid, Settled, Token
from followspot.transport.zenoh_session import locators, open_session

__all__ = ["ZenohReader", "ZenohWriter", "locators", "open_session"]

NUMBER = Struct("<QQ")
"""Attachment: number of the token, and of messages up to and with it."""
CREDIT = Struct("<QQ?")
"""What a reader reports: messages consumed, tokens taken, whether the end is among them."""
WINDOW = 256
"""Most tokens under way: as many settled times do not fill any buffer, so that a put does not block."""


class ZenohWriter:
    """`PortWriter` for readers anywhere that a session reaches."""

    def __init__(self, session: zenoh.Session, key: str, readers: Sequence[str], depth: int) -> None:
        """key: of the port, for example ``followspot/RUN/color/cam0/out``; readers: their names."""
        self._depth = depth
        self._index = {quote(name, safe=""): index for index, name in enumerate(readers)}
        self._reports = [(0, 0, False)] * len(readers)
        self._present: set[int] = set()
        self._gone: set[int] = set()
        self._tokens = 0
        self._messages = 0
        self._held: Settled | None = None
        self._ending = False
        self._waiting = False
        self._bell = Bell()
        self._publisher = _publisher(session, key)
        self._declared = [
            session.declare_subscriber(f"{key}/credit/*", Callback(self._on_report, indirect=False)),
            _presence(session, f"{key}/alive/reader/*", self._on_presence),
            session.liveliness().declare_token(f"{key}/alive/writer"),
        ]

    @property
    def lost(self) -> frozenset[int]:
        """Indices of the readers that are gone before the end."""
        return frozenset(index for index in tuple(self._gone) if not self._reports[index][2])

    def matched(self) -> bool:
        """Whether every reader is there, and would get what is sent."""
        return len(self._present) == len(self._reports) and self._reached()

    def credit(self) -> int:
        """How many messages may be sent now."""
        reports = self._living()
        if not reports:
            return self._depth
        if self._tokens - min(taken for _, taken, _ in reports) >= WINDOW:
            return 0
        return max(0, self._depth - self._messages + min(consumed for consumed, _, _ in reports))

    def send(self, token: Message | Settled) -> None:
        """Put the token on the key; see `PortWriter.send`."""
        if isinstance(token, Settled):
            self._held = token
            self._ending |= token.bound == END
            self._send_held()
            return
        payload = pack(token)
        if self.credit() <= 0:
            raise RuntimeError("a message was sent without credit")
        self._send_held()
        self._messages += 1
        self._put(payload)

    def loan(self, shape: Sequence[int], dtype: str) -> Array:
        """Ordinary memory: Zenoh copies in any case."""
        return np.empty(shape, dtype)

    def flush(self) -> bool:
        """Send the settled time that had to wait. True when nothing waits; the end must have arrived."""
        self._waiting = True
        self._send_held()
        return self._held is None and not (self._ending and any(not ended for _, _, ended in self._living()))

    def filenos(self) -> list[int]:
        """The bell."""
        return [self._bell.fileno()]

    def want_credit(self) -> None:
        """Ring the bell at the next report."""
        self._waiting = True

    def drain(self) -> None:
        """Hush the bell."""
        self._bell.hush()
        self._send_held()

    def close(self) -> None:
        """Undeclare everything; the session stays open."""
        _undeclare([*reversed(self._declared), self._publisher])
        self._bell.close()

    def _living(self) -> list[tuple[int, int, bool]]:
        return [report for index, report in enumerate(self._reports) if index not in self._gone]

    def _reached(self) -> bool:
        return self._publisher.matching_status.matching  # type: ignore[attr-defined,no-any-return]  # no bool

    def _send_held(self) -> None:
        held = self._held
        reports = self._living()
        if held is None or (reports and self._tokens - min(taken for _, taken, _ in reports) >= WINDOW):
            return
        self._held = None
        self._put(pack(held))

    def _put(self, payload: bytes) -> None:
        number = NUMBER.pack(self._tokens, self._messages)
        self._tokens += 1
        try:
            if self._reached():  # a put that nobody gets is still copied
                self._publisher.put(payload, attachment=number)
        except zenoh.ZError:  # the session is closed
            self._gone.update(range(len(self._reports)))

    def _on_report(self, sample: zenoh.Sample) -> None:
        index = self._index.get(_last(sample))
        report = sample.payload.to_bytes()
        if index is None or len(report) != CREDIT.size:
            return
        consumed, taken, ended = CREDIT.unpack(report)
        self._reports[index] = min(consumed, self._messages), min(taken, self._tokens), ended
        if self._waiting:
            self._waiting = False
            self._bell.ring()

    def _on_presence(self, sample: zenoh.Sample) -> None:
        index = self._index.get(_last(sample))
        if index is not None:
            if sample.kind == zenoh.SampleKind.PUT:
                self._present.add(index)
            else:
                self._gone.add(index)
            self._bell.ring()


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
        self._report = _publisher(session, f"{key}/credit/{name}")
        self._declared = [
            session.declare_subscriber(key, Callback(self._on_arrival, indirect=False)),
            _presence(session, f"{key}/alive/writer", self._on_presence),
            session.liveliness().declare_token(f"{key}/alive/reader/{name}"),
        ]

    @property
    def lost(self) -> bool:
        """Whether the writer was there and is gone without an end."""
        return self._gone and not self._ended

    def matched(self) -> bool:
        """Whether the writer is there, and would get reports."""
        return self._writer and self._report.matching_status.matching  # type: ignore[attr-defined]

    def fileno(self) -> int:
        """The bell."""
        return self._bell.fileno()

    def poll(self) -> list[Token]:
        """Everything that has arrived."""
        self._bell.hush()
        tokens: list[Token] = []
        for _ in range(len(self._arrived)):
            self._take(self._arrived.popleft(), tokens)
        if self._ended or self._tokens - self._reported >= WINDOW // 4:
            self._send_report()
        return tokens

    def consumed(self, count: int = 1) -> None:
        """Give credit for messages that were taken out of the queue."""
        self._consumed += count
        self._send_report()

    def close(self) -> None:
        """Undeclare everything; the session stays open."""
        _undeclare([*reversed(self._declared), self._report])
        self._bell.close()

    def _take(self, sample: zenoh.Sample, tokens: list[Token]) -> None:
        """Append what one sample says, and what is missing before it."""
        attachment = b"" if sample.attachment is None else sample.attachment.to_bytes()
        if len(attachment) != NUMBER.size:
            tokens.append(Invalid("a sample that no port sent: it has no number"))
            return
        number, messages = NUMBER.unpack(attachment)
        if number < self._tokens:
            tokens.append(Invalid(f"token {number} came again, expected {self._tokens}"))
            return
        if number > self._tokens:
            tokens.append(Invalid(f"gap: expected token {self._tokens}, {number - self._tokens} are missing"))
        token = self._token(sample)
        tokens.append(token)
        credit = messages - self._messages - isinstance(token, Message)
        self._tokens = number + 1
        self._messages = messages
        if credit > 0:  # of messages that were lost or invalid
            self.consumed(credit)

    def _token(self, sample: zenoh.Sample) -> Token:
        if len(sample.payload) > MAX_PACKED:
            return Invalid(f"{len(sample.payload)} bytes, at most {MAX_PACKED} allowed")
        try:
            token = unpack(sample.payload.to_bytes(), self._kind)
        except InvalidMessage as error:
            return Invalid(str(error))
        self._ended |= isinstance(token, Settled) and token.bound == END
        return token

    def _send_report(self) -> None:
        self._reported = self._tokens
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._report.put(CREDIT.pack(self._consumed, self._tokens, self._ended))

    def _on_arrival(self, sample: zenoh.Sample) -> None:
        if len(self._arrived) < self._limit:  # a flood from a stranger; the numbers show what is missing
            self._arrived.append(sample)
        self._bell.ring()

    def _on_presence(self, sample: zenoh.Sample) -> None:
        self._writer = sample.kind == zenoh.SampleKind.PUT
        self._gone = not self._writer
        self._bell.ring()


def _publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    return session.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK, express=True)


def _presence(session: zenoh.Session, key: str, callback: Any) -> Any:
    """Watch the liveliness tokens of the other side, those that are there already included."""
    return session.liveliness().declare_subscriber(key, Callback(callback, indirect=False), history=True)


def _undeclare(declared: Iterable[Any]) -> None:
    for entity in declared:
        with contextlib.suppress(zenoh.ZError):  # the session was closed first
            entity.undeclare()


def _last(sample: zenoh.Sample) -> str:
    return str(sample.key_expr).rpartition("/")[2]
