"""Heads of messages: the part that messages of a port share, packed and read only once.

Most messages of a port differ in their arrays and in three numbers of their header. Everything else is the
head of the datagram: name of the type, source, scalars, and name, dtype and shape of each array. A port has
few heads, which alternate: as many blobs as before, or one fewer; a period rounded up, or down.
"""

from __future__ import annotations

from collections.abc import Sequence
from struct import Struct
from typing import Any, NamedTuple

import numpy as np

from followspot.messages import Array, InvalidMessage, Message
from followspot.transport.codec import check_source, codec_of
from followspot.transport.wire import ALIGN, PREFIX, pack_head, padded, unpack_head

_MOST_KNOWN = 64
"""Most heads that each side of a port remembers; a port with more has them packed or read again."""
_FLOAT = Struct("<d")


def places_of(kind: type[Message]) -> Struct:
    """Layout of the byte of a slot at which each array of a message begins."""
    return Struct(f"<{len(kind.columns)}q")


class HeadPacker:
    """Packs heads of messages of one type."""

    def __init__(self, kind: type[Message]) -> None:
        """Raises TypeError if a column is not made of plain numbers."""
        self.kind = kind
        self.places = places_of(kind)
        """Layout of the bytes of a slot at which the arrays begin."""
        self._codec = codec_of(kind)
        self._names = tuple((name, scalar is float) for name, scalar in kind.scalars)
        self._repeated: list[Any] | None = None
        self._packed = b"", 0
        self._known: dict[tuple[Any, ...], tuple[bytes, int]] = {}

    def pack(self, message: Message, arrays: list[Array]) -> tuple[bytes, int]:
        """The head of a sealed message with these arrays, and the padded size of the arrays, bytes.

        Raises InvalidMessage if the head is too large.
        """
        values = message.__dict__
        repeated: list[Any] = [message.header.source]
        for name, is_float in self._names:  # equal floats need not have equal bits: 0.0 and -0.0
            repeated.append(_FLOAT.pack(values[name]) if is_float else values[name])
        for array in arrays:
            repeated.append(array.shape)  # noqa: PERF401  # a comprehension is a call more
        if repeated != self._repeated:
            key = tuple(repeated)
            known = self._known.get(key)
            if known is None:
                scalars, columns = self._codec.contract(message, arrays)
                head = pack_head((self._codec.name, repeated[0], scalars, columns))
                known = head, sum([padded(array.nbytes) for array in arrays])
                _remember(self._known, key, known)
            self._packed, self._repeated = known, repeated
        return self._packed


class Head(NamedTuple):
    """The content of a head. shapes, spans: of each array, and its size in bytes."""

    source: str
    scalars: dict[str, Any]
    shapes: list[tuple[int, ...]]
    spans: list[int]


class HeadReader:
    """Reads heads of messages of one type."""

    def __init__(self, kind: type[Message]) -> None:
        """Raises TypeError if a column is not made of plain numbers."""
        self._codec = codec_of(kind)
        self.dtypes = self._codec.dtypes
        """Data types of the arrays."""
        self._places = places_of(kind)
        self._head: Head | None = None
        self._packed = b""
        self._known: dict[bytes, Head] = {}

    def read(self, data: bytearray, start: int, end: int) -> tuple[Head, int]:
        """The head that begins at byte `start` of `end`, and the byte after it. Raises InvalidMessage."""
        after = start + len(self._packed)
        if self._head is not None and after <= end and data.startswith(self._packed, start):
            return self._head, after
        if end - start >= PREFIX.size:
            size = padded(PREFIX.size + PREFIX.unpack_from(data, start)[1])
            packed = bytes(data[start : min(start + size, end)])
            if packed in self._known:
                self._head, self._packed = self._known[packed], packed
                return self._head, start + size
        fields, size = unpack_head(memoryview(data)[start:end])
        if len(fields) != 4 or fields[0] != self._codec.name:
            found = f"{str(fields[0])[:80]} of {len(fields)}"
            raise InvalidMessage(f"expected {self._codec.name} of 4 parts, not {found}")
        _, source, scalars, columns = fields
        check_source(source)
        head = Head(source, self._codec.scalars(scalars), *self._codec.shapes(columns))
        self._head, self._packed = head, bytes(data[start : start + size])
        _remember(self._known, self._packed, head)
        return head, start + size

    def views(self, head: Head, starts: Sequence[int], body: Array) -> list[Array]:
        """The arrays that begin at these bytes of a body, (B,) uint8."""
        return [
            np.ndarray(shape, dtype, body, start)
            for dtype, shape, start in zip(self.dtypes, head.shapes, starts, strict=True)
        ]

    def places(self, head: Head, data: bytearray, start: int, end: int, size: int) -> Sequence[int]:
        """The byte of a slot at which each array begins, as a datagram tells behind its head.

        start, end: of the places in the datagram; size: what the slot holds, bytes. Raises InvalidMessage.
        """
        if end - start != self._places.size:
            raise InvalidMessage(f"the places of {len(head.spans)} arrays take {end - start} bytes")
        starts = self._places.unpack_from(data, start)
        for place, span in zip(starts, head.spans, strict=True):
            if place % ALIGN or place < 0 or place + span > size:
                raise InvalidMessage(f"an array of {span} bytes at {place} lies outside the {size} that came")
        return starts


def _remember(known: dict[Any, Any], key: Any, value: Any) -> None:
    """Add an entry; forget all others if there are too many."""
    if len(known) >= _MOST_KNOWN:
        known.clear()
    known[key] = value
