"""The writing end of an edge that drops messages: a slow reader causes no backpressure."""

from __future__ import annotations

import socket
from collections import deque
from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

from followspot.messages import Array, InvalidMessage, Message
from followspot.transport.edge import PortWriter
from followspot.transport.token import ABSENT, UNKNOWN, Watermark

_PLENTY = 1 << 30


@runtime_checkable
class Replaceable(Protocol):
    """A writer whose readers can be replaced."""

    def replace(self, index: int, sock: socket.socket) -> None:
        """See `RingWriter.replace`."""


class DroppingWriter:
    """`PortWriter` of one reader that always takes a message.

    Messages without credit wait here, as many as the edge is deep; if more come, the oldest is dropped.
    Watermarks keep their place between the messages.
    """

    def __init__(self, inner: PortWriter, depth: int) -> None:
        """inner: the writer, whose credit limits messages on their way; depth: messages that wait."""
        self.inner = inner
        self.depth = depth
        self.dropped: Callable[[], None] = lambda: None
        """Called for each message that is dropped."""
        self.refused: Callable[[str], None] = lambda reason: None
        """Called with the reason for each message that cannot be sent."""
        self._waiting: deque[Message | Watermark] = deque()
        self._messages = 0
        """Messages among the tokens that wait."""

    @property
    def lost(self) -> frozenset[int]:
        """See `PortWriter`; the inner writer answers."""
        return self.inner.lost

    @property
    def rejected(self) -> int:
        """See `PortWriter`; the inner writer answers."""
        return self.inner.rejected

    def newly_dead(self) -> list[tuple[int, int]]:
        """See `PortWriter`; messages that wait here are dropped, or sent to the next reader."""
        return self.inner.newly_dead()

    def matched(self) -> bool:
        """See `PortWriter`; the inner writer answers."""
        return self.inner.matched()

    def credit(self) -> int:
        """A number that no writer uses up: the edge always takes a message."""
        return _PLENTY

    def send(self, token: Message | Watermark, watermark: int = UNKNOWN) -> None:
        """Send the token, or let it wait and drop the oldest message."""
        if isinstance(token, Watermark):
            if self._waiting and isinstance(self._waiting[-1], Watermark):
                self._waiting.pop()
        elif self.inner.lost:
            return
        else:
            if self._messages == self.depth:
                self._drop_oldest()
            self._messages += 1
        self._waiting.append(token)
        if watermark != UNKNOWN:
            self._waiting.append(Watermark(watermark))
        self._pass_on()

    def loan(self, shape: Sequence[int], dtype: str) -> Array | None:
        """None: whether a message will be sent is not known when it is made."""
        return None

    def flush(self) -> bool:
        """Send the waiting messages. True when none waits."""
        self._pass_on()
        return self.inner.flush() and not self._waiting

    @property
    def all_taken(self) -> bool:
        """See `PortWriter`; the inner writer answers."""
        return self.inner.all_taken

    def dismiss(self, index: int) -> None:
        """Send the reader nothing more."""
        self.inner.dismiss(index)

    def filenos(self) -> list[int]:
        """See `PortWriter`; the inner writer answers."""
        return self.inner.filenos()

    def want_credit(self) -> None:
        """Ask the reader for a wake-up."""
        self.inner.want_credit()

    def drain(self) -> None:
        """Clear wake-ups, and send the waiting messages; drop them if the reader died."""
        self.inner.drain()
        self._pass_on()

    def close(self) -> None:
        """Close the inner writer."""
        self.inner.close()

    def replace(self, index: int, sock: socket.socket) -> None:
        """Serve another reader in the place of the one that is gone."""
        assert isinstance(self.inner, Replaceable)
        self.inner.replace(index, sock)

    def _pass_on(self) -> None:
        """Send messages while there is credit; ask for a wake-up if one must wait."""
        if self.inner.lost:
            while self._messages:
                self._drop_oldest()
        while self._waiting:
            token = self._waiting[0]
            if isinstance(token, Message):
                if self.inner.credit() <= 0 and not self._credit_now():
                    return
                self._messages -= 1
            self._waiting.popleft()
            watermark = self._watermark_after(token)
            try:
                self.inner.send(token, watermark)
            except InvalidMessage as error:
                self.refused(str(error))
                if watermark != UNKNOWN:
                    self.inner.send(Watermark(watermark))

    def _watermark_after(self, token: Message | Watermark) -> int:
        """The watermark that waits behind a message, which it takes along; `UNKNOWN` if there is none."""
        if isinstance(token, Message) and self._waiting and isinstance(self._waiting[0], Watermark):
            found = self._waiting[0].time
            if found < ABSENT:
                self._waiting.popleft()
                return found
        return UNKNOWN

    def _credit_now(self) -> bool:
        """Ask for a wake-up; return whether credit has come meanwhile."""
        self.inner.want_credit()
        return self.inner.credit() > 0

    def _drop_oldest(self) -> None:
        """Remove the oldest message; the watermarks before and after it become one."""
        for index, token in enumerate(self._waiting):
            if isinstance(token, Message):
                del self._waiting[index]
                after = self._waiting[index] if index < len(self._waiting) else None
                if index and isinstance(after, Watermark):
                    del self._waiting[index - 1]
                self._messages -= 1
                self.dropped()
                return
