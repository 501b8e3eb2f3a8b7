"""The writing end of an edge over Zenoh (docs/wire.md).

Zenoh loses nothing between connected peers as long as its buffers do not overflow, so credit bounds what is
under way. Zenoh's threads only take notes and set the wake-up event; the worker's thread does all else.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping, Sequence
from functools import partial

import zenoh
from zenoh.handlers import Callback

from followspot.graph.plan import EdgeCodec
from followspot.messages import Array, Message
from followspot.transport.codec import pack
from followspot.transport.keys import reader_key
from followspot.transport.token import END, UNKNOWN, Watermark
from followspot.transport.wakeup_event import WakeupEvent
from followspot.transport.zenoh.codec import pack_as
from followspot.transport.zenoh.flow_control import FlowControl, ReaderRecord
from followspot.transport.zenoh.terms import (
    KNOWN,
    NUMBER,
    START,
    codec_key,
    has_subscriber,
    presence,
    publisher,
    undeclare,
)

_REPEAT = 0.5
"""Seconds after which a reader that does not report is sent its start again."""


class ZenohWriter:
    """`PortWriter` for readers on any host that a session reaches.

    A reader that comes, comes back, or comes as another incarnation joins at the next token: the writer tells
    it which that is, and how many messages it has put for this reader before.
    """

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        readers: Mapping[str, str],
        depth: int,
        *,
        codec: EdgeCodec = "raw",
        incarnation: int = 0,
    ) -> None:
        """Declare the port on its key.

        key: of the port, for example ``followspot/RUN/pc-left/color/cam0/out``; readers: the host of each,
        by its name, "" for the operator's own: the writer believes no other host; depth: messages in flight;
        incarnation: how many writers this port had before; a later one waits for no reader.
        """
        self._key = key = codec_key(key, codec)
        self._codec = codec
        self._incarnation = incarnation
        self._wakeup = WakeupEvent()
        self._flow = FlowControl(readers, depth, incarnation, self._wakeup.set)
        self._start_sent_at = 0.0
        self._pending: Watermark | None = None
        """A watermark that waits for room."""
        self._last: Watermark | None = None
        """The watermark that was put after the last message: every reader that joins is told it again."""
        self._ending = False
        self._wants_credit = False
        self._session = session
        self._publisher = publisher(session, key)
        readers_key = reader_key(key, "*")
        on_report = Callback(self._on_report, indirect=False)
        self._declared = [
            session.declare_subscriber(f"{readers_key}/credit/*", on_report),
            presence(session, f"{readers_key}/*/*/*", self._flow.take_presence),
            presence(session, f"{readers_key}/done/*/*/*", self._flow.take_end),
            session.liveliness().declare_token(f"{key}/alive/writer/{incarnation}"),
        ]

    @property
    def lost(self) -> frozenset[int]:
        """Indices of the readers that `drain` found gone before the end."""
        return self._flow.lost

    def newly_dead(self) -> list[tuple[int, int]]:
        """Readers that other incarnations have replaced since the last call; see `PortWriter.newly_dead`.

        A reader that left may just be cut off; when it is back, it is told how many messages it missed.
        """
        return self._flow.deaths()

    @property
    def rejected(self) -> int:
        """Count of reports and liveliness tokens that were malformed, or not from their reader's host."""
        return self._flow.refused

    def matched(self) -> bool:
        """Whether every reader is present, knows where to start, and would get the next message."""
        self._notice()
        self._repeat_start()
        joined = all(reader.present and not reader.silent for reader in self._flow.readers)
        return joined and has_subscriber(self._publisher)

    def credit(self) -> int:
        """How many messages may be sent now."""
        return self._flow.credit()

    def send(self, token: Message | Watermark, watermark: int = UNKNOWN) -> None:
        """Put the token on the key; see `PortWriter.send`."""
        if isinstance(token, Watermark):
            self._pending = token
            self._ending |= token.time == END
            self._send_pending()
            return
        payload = pack_as(token, self._codec)
        if self.credit() <= 0:
            raise RuntimeError("a message was sent without credit")
        self._send_pending()
        known = watermark != UNKNOWN
        self._last = Watermark(watermark) if known else None
        self._flow.count_message()
        self._put(payload, KNOWN.pack(watermark) if known else b"")

    def loan(self, shape: Sequence[int], dtype: str) -> Array | None:
        """None: Zenoh copies in any case."""
        return None

    def flush(self) -> bool:
        """Send the watermark that had to wait. True when nothing waits, and the end, if sent, has arrived.

        Changes of readers are left to `drain`, whose caller takes note of them.
        """
        self._wants_credit = True
        self._repeat_start()
        self._send_pending()
        return self._pending is None and (self._flow.ended or not self._ending)

    @property
    def all_taken(self) -> bool:
        """Whether every reader has reported that it has taken all tokens."""
        return self._flow.all_taken

    def dismiss(self, index: int) -> None:
        """See `PortWriter.dismiss`."""
        self._flow.dismiss(index)

    def filenos(self) -> list[int]:
        """The wake-up event."""
        return [self._wakeup.fileno()]

    def want_credit(self) -> None:
        """Set the wake-up event at the next report."""
        self._wants_credit = True

    def drain(self) -> None:
        """Clear the wake-up event, notice readers that came and left, send the waiting messages."""
        self._wakeup.clear()
        self._notice()
        self._send_pending()

    def close(self) -> None:
        """Undeclare everything; the session stays open."""
        undeclare([*reversed(self._declared), self._publisher])
        self._flow.close()
        self._wakeup.close()

    def _notice(self) -> None:
        for reader in self._flow.changes():
            self._send_start(reader)

    def _repeat_start(self) -> None:
        """Repeat the start to silent readers, and ask for them: a new link may have swallowed it."""
        if time.monotonic() > self._start_sent_at + _REPEAT:
            for reader in self._flow.readers:
                if reader.silent:
                    self._send_start(reader)
                    self._ask_for(reader)

    def _ask_for(self, reader: ReaderRecord) -> None:
        """Ask whether the liveliness token of a silent reader exists.

        While Zenoh declares a subscriber of tokens, it may tell it last of a token that has just gone. Such a
        reader would hold up the port for ever.
        """
        taken = partial(self._flow.take_absence, reader, reader.incarnation, reader.arrivals)
        replies: list[zenoh.Reply] = []
        token = f"{reader_key(self._key, reader.host)}/alive/{reader.name}/{reader.incarnation}"
        answered = Callback(replies.append, drop=lambda: None if replies else taken(), indirect=False)
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._session.liveliness().get(token, answered, timeout=_REPEAT)

    def _send_start(self, reader: ReaderRecord) -> None:
        """Tell a reader which token comes next, and how many messages it was given before."""
        self._start_sent_at = time.monotonic()
        start = START.pack(self._incarnation, self._flow.tokens, self._flow.messages, reader.given)
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._session.put(
                f"{self._key}/start/{reader.name}/{reader.incarnation}",
                start,
                congestion_control=zenoh.CongestionControl.BLOCK,
            )
        if self._last is not None:
            self._put(pack(self._last))

    def _send_pending(self) -> None:
        """Send the watermark that waits, unless the window of tokens is full."""
        pending = self._pending
        if pending is not None and not self._flow.window_is_full():
            self._pending, self._last = None, pending
            self._put(pack(pending))

    def _put(self, payload: bytes, known: bytes = b"") -> None:
        flow = self._flow
        number = NUMBER.pack(self._incarnation, flow.tokens, flow.messages)
        flow.tokens += 1
        try:
            if has_subscriber(self._publisher):  # a put without a subscriber is still copied
                self._publisher.put(payload, attachment=number + known)
        except zenoh.ZError:  # the session is closed
            flow.lose_all()
            self._wakeup.set()

    def _on_report(self, sample: zenoh.Sample) -> None:
        if self._flow.take_report(sample) and self._wants_credit:
            self._wants_credit = False
            self._wakeup.set()
