"""Decodes the datagrams of a ring into tokens, and refuses datagrams that no writer sends."""

from __future__ import annotations

import socket
import sys
from collections.abc import Sequence

import numpy as np

from followspot.messages import Array, Header, InvalidMessage, Message, in_range
from followspot.transport.codec import codec_of, successive
from followspot.transport.ring.heads import Head, HeadReader
from followspot.transport.ring.notification import (
    CARRIED,
    CARRIES,
    HELLO,
    INLINE,
    INLINE_BYTES,
    MESSAGE,
    NOTIFICATION,
    SLOT,
    WATERMARK,
)
from followspot.transport.ring.reader_memory import ReaderMemory
from followspot.transport.token import MAX_WATERMARK, UNKNOWN, Invalid, Token, Watermark, is_watermark
from followspot.transport.wire import MAX_HEAD, aligned

LARGEST = MESSAGE.size + MAX_HEAD + 2 * INLINE_BYTES
"""Most bytes of a datagram."""
_MOST_MISSING = 256
"""Most messages that may be missing before one; a socket loses none, so a larger gap is refused."""


class Decoder:
    """Decodes datagrams to one reader, in the order in which they come."""

    def __init__(self, sock: socket.socket, kind: type[Message]) -> None:
        """sock: of the reader; kind: type of the messages."""
        self.buffer = bytearray(LARGEST)
        """The buffer for the next datagram."""
        self.sequence = 0
        """Number of the next message."""
        self.first = 0
        """Number of the first message: those before were not for this reader."""
        self.refused = 0
        """Datagrams that no writer sends."""
        self._codec = codec_of(kind)
        self._heads = HeadReader(kind)
        self.memory = ReaderMemory(self._heads, sock)

    def shares(self, end: int, extra: Sequence[tuple[int, int, bytes]]) -> tuple[int, int] | None:
        """`CARRIES` or `CARRIED` and the number of the other edge; None if the datagram is of another kind.

        One edge then carries the messages of both. end, extra: as of :meth:`tokens`.
        """
        if self.buffer[0] not in (CARRIES, CARRIED) or extra or end != NOTIFICATION.size:
            return None
        return self.buffer[0], int(NOTIFICATION.unpack_from(self.buffer)[-1])

    def tokens(self, end: int, extra: Sequence[tuple[int, int, bytes]]) -> list[Token]:
        """The tokens of the datagram in the buffer; none if it has another purpose, or no writer sends it.

        end: its size, bytes; extra: the file descriptor that it brought, if any. Raises FollowspotError if
        memory cannot be mapped.
        """
        kind, number, slot, size, value, *numbers, watermark = MESSAGE.unpack_from(self.buffer)
        if end < NOTIFICATION.size:
            self.refused += 1
        elif extra:
            fd = int.from_bytes(extra[0][2], sys.byteorder)
            if not self.memory.map(fd, kind, number, slot, size, value):
                self.refused += 1
            elif kind == HELLO:
                self.first = self.sequence = value
        elif kind == WATERMARK and is_watermark(value):
            return [Watermark(value)]
        elif kind in (INLINE, SLOT) and 0 <= value - self.sequence <= _MOST_MISSING:
            found = self._missing(value) if value != self.sequence else []
            self.sequence = value + 1
            try:
                head, start = self._heads.read(self.buffer, MESSAGE.size, end)
                header = in_range(Header(head.source, *numbers))
                if kind == INLINE:
                    arrays = self._inline(head, start, end, size)
                else:
                    starts = self._heads.places(head, self.buffer, start, end, size)
                    arrays = self.memory.arrays(head, starts, number, slot, size, self.sequence)
                found.append(self._codec.message(header, head.scalars, arrays))
            except InvalidMessage as error:
                found.append(Invalid(str(error)))
                if kind == SLOT and self.memory.has(number, slot, size):
                    self.memory.release(number, slot, self.sequence)
            if end >= MESSAGE.size and watermark != UNKNOWN:
                self._announce(watermark, found)
            return found
        else:
            self.refused += 1
        return []

    def _missing(self, number: int) -> list[Token]:
        """An `Invalid` for each message that is missing before this one."""
        missing = range(self.sequence, number)
        return [Invalid(f"gap: message {n} of the port never came", missing=True) for n in missing]

    def _announce(self, watermark: int, tokens: list[Token]) -> None:
        """Append the watermark, ns, that came with a message; the end and an absence come by themselves."""
        if abs(watermark) <= MAX_WATERMARK:
            tokens.append(Watermark(watermark))
        else:
            self.refused += 1

    def _inline(self, head: Head, start: int, end: int, size: int) -> list[Array]:
        """Arrays that the datagram brought behind byte `start`, in new memory."""
        if end != start + size:
            raise InvalidMessage(f"{size} bytes of arrays announced, {end - start} came")
        starts = successive(head.spans, size)
        body = aligned(size)
        body[:] = np.frombuffer(self.buffer, np.uint8, size, start)
        body.flags.writeable = False
        return self._heads.views(head, starts, body)
