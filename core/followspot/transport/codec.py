"""Messages to bytes and back; everything is checked on arrival (docs/wire.md).

Both sides know the message type. The head repeats its contract, so that a reader of another version notices,
and other programs can read it. Bytes that do not fit raise InvalidMessage.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from followspot.message_checks.sealing import beyond_truth, check_shape
from followspot.message_checks.type_names import named_type, named_value
from followspot.messages import (
    MAX_BYTES,
    MAX_INTEGER,
    MIN_INTEGER,
    Array,
    Header,
    InvalidMessage,
    Message,
    in_range,
)
from followspot.transport.token import Watermark, is_watermark
from followspot.transport.wire import ALIGN, MAX_HEAD, RAW, aligned, pack_head, padded, unpack_head

MAX_SOURCE = 1000
"""Longest name of a source, characters."""
MAX_PACKED = MAX_BYTES + 2 * MAX_HEAD
"""Largest packed token, bytes: the arrays, their padding, and the head."""


class Codec:
    """Encodes and decodes one message type; prepares once everything that depends on the type alone."""

    def __init__(self, kind: type[Message]) -> None:
        self.kind = kind
        self.name = kind.__qualname__
        self._shaped: tuple[Any, list[tuple[int, ...]], list[int]] = (self, [], [])
        self._columns = tuple((c.name, c.dtype.str, c.shape, c.dtype) for c in kind.columns)
        self.dtypes = tuple(c.dtype for c in kind.columns)

    def arrays(self, message: Message) -> list[Array]:
        """The arrays of a message, in the order of its columns."""
        return [getattr(message, name) for name, _, _, _ in self._columns]

    def contract(
        self, message: Message, arrays: Sequence[Array]
    ) -> tuple[dict[str, Any], list[tuple[str, str, tuple[int, ...]]]]:
        """The scalars, and name, dtype and shape of each array of a message, as heads have them."""
        scalars = {name: getattr(message, name) for name, _ in self.kind.scalars}
        columns = [(c[0], c[1], array.shape) for c, array in zip(self._columns, arrays, strict=True)]
        return scalars, columns

    def head(self, message: Message, arrays: Sequence[Array]) -> bytes:
        """The packed head of a sealed message with these arrays. Raises InvalidMessage if it is too large."""
        return pack_head((self.name, *message.header, *self.contract(message, arrays)))

    def decode(self, head: list[Any], body: Array) -> Message:
        """The message of an unpacked head, with read-only views of `body` as its arrays.

        body: (B,) uint8, aligned, which the arrays fill one after the other. Raises InvalidMessage.
        """
        if len(head) != 7 or head[0] != self.name:
            raise InvalidMessage(f"expected {self.name} of 7 parts, not {str(head[0])[:80]} of {len(head)}")
        header = _header(*head[1:5])
        values = self.scalars(head[5])
        shaped = self._shaped
        if head[6] != shaped[0]:  # mostly the columns are those of the message before
            shaped = self._shaped = (head[6], *self.shapes(head[6]))
        _, shapes, spans = shaped
        body.flags.writeable = False
        starts = successive(spans, len(body))
        arrays = [
            np.ndarray(shape, dtype, body, start)
            for dtype, shape, start in zip(self.dtypes, shapes, starts, strict=True)
        ]
        return self.message(header, values, arrays)

    def message(self, header: Header, scalars: dict[str, Any], arrays: Sequence[Array]) -> Message:
        """The message with these read-only arrays of the right shapes.

        Raises InvalidMessage if truth values are none.
        """
        values = dict(scalars)
        for (name, _, _, dtype), array in zip(self._columns, arrays, strict=True):
            if dtype.kind == "b" and beyond_truth(array):
                raise InvalidMessage(f"{name} holds truth values other than 0 and 1")
            values[name] = array
        message = self.kind(**values)
        message.__dict__["header"] = header
        return message

    def scalars(self, found: Any) -> dict[str, Any]:
        """The scalars of a head, each of the type that the contract names. Raises InvalidMessage."""
        if type(found) is not dict or len(found) != len(self.kind.scalars):
            raise InvalidMessage(f"the scalars are not those of {self.name}")
        values = {}
        for name, kind in self.kind.scalars:
            value = found.get(name)
            if type(value) is list and kind == tuple[str, ...] and all(type(word) is str for word in value):
                value = tuple(value)
            elif type(value) is not kind:
                raise InvalidMessage(f"{name} is {named_value(value)}, declared {named_type(kind)}")
            elif type(value) is int and not MIN_INTEGER <= value <= MAX_INTEGER:
                raise InvalidMessage(f"{name} is {value}, which is no number of 64 bits")
            values[name] = value
        return values

    def shapes(self, found: Any) -> tuple[list[tuple[int, ...]], list[int]]:
        """Shape and size in bytes of each array, from the columns in a head. Raises InvalidMessage."""
        if type(found) is not list or len(found) != len(self._columns):
            raise InvalidMessage(f"the columns are not those of {self.name}")
        sizes: dict[str, int] = {}
        shapes = []
        spans = []
        for row, (name, code, declared, dtype) in zip(found, self._columns, strict=True):
            if type(row) is not list or row[:2] != [name, code] or len(row) != 3 or type(row[2]) is not list:
                raise InvalidMessage(f"{str(row)[:80]} is not the column {name} of dtype {code}")
            shape = tuple(row[2])
            largest = span = dtype.itemsize
            for size in shape:
                if type(size) is not int or size < 0:
                    raise InvalidMessage(f"{name} has the impossible shape {str(shape)[:80]}")
                span *= size
                largest *= size or 1  # numpy refuses a huge shape even where another size is 0
            if largest > MAX_BYTES:
                raise InvalidMessage(f"{name} of shape {shape} has more than {MAX_BYTES} bytes")
            check_shape(name, shape, declared, sizes)
            shapes.append(shape)
            spans.append(span)
        return shapes, spans


_CODECS: dict[type[Message], Codec] = {}


def codec_of(kind: type[Message]) -> Codec:
    """The codec of a message type. Raises TypeError if a column is not made of plain numbers."""
    codec = _CODECS.get(kind)
    if codec is None:
        codec = _CODECS[kind] = Codec(kind)
    return codec


def pack(token: Message | Watermark) -> bytes:
    """A sealed message, or a watermark, in one piece. Raises InvalidMessage if its head is too large."""
    if isinstance(token, Watermark):
        return pack_head((None, token.time))
    codec = codec_of(type(token))
    arrays = codec.arrays(token)
    parts = [codec.head(token, arrays)]
    for array in arrays:
        parts += array.tobytes(), bytes(-array.nbytes % ALIGN)
    return b"".join(parts)


def unpack(data: bytes, kind: type[Message]) -> Message | Watermark:
    """The token that `pack` packed, its arrays in new memory. Raises InvalidMessage."""
    if len(data) > MAX_PACKED:
        raise InvalidMessage(f"{len(data)} bytes, at most {MAX_PACKED} allowed")
    head, start = unpack_head(data)
    if data[1] != RAW:
        raise InvalidMessage(f"its arrays are coded in way {data[1]}")
    if head[0] is None:
        return Watermark(_watermark_time(head, len(data) - start))
    body = aligned(len(data) - start)
    body[:] = np.frombuffer(data, np.uint8, offset=start)
    return codec_of(kind).decode(head, body)


def header_of(data: bytes) -> Header:
    """The header of a packed message; its arrays are not looked at. Raises InvalidMessage."""
    head, _ = unpack_head(data)
    if len(head) != 7:
        raise InvalidMessage(f"expected a message of 7 parts, not {len(head)}")
    return _header(*head[1:5])


def successive(spans: Sequence[int], size: int) -> list[int]:
    """Indices, bytes, at which arrays of these sizes begin if they fill `size` bytes one after the other."""
    starts = []
    end = 0
    for span in spans:
        starts.append(end)
        end += padded(span)
    if end != size:
        raise InvalidMessage(f"the arrays take {end} bytes, {size} came")
    return starts


def _header(source: Any, seq: Any, time: Any, entered: Any) -> Header:
    header = Header(source, seq, time, entered)
    if not type(seq) is type(time) is type(entered) is int:
        raise InvalidMessage(f"the header {str(header)[:80]} is not a name and three numbers")
    check_source(source)
    return in_range(header)


def check_source(source: Any) -> None:
    """Raise InvalidMessage if this cannot be the name of a source."""
    if type(source) is not str:
        raise InvalidMessage(f"the header begins with {str(source)[:80]}, which is no name of a source")
    if len(source) > MAX_SOURCE:
        raise InvalidMessage(
            f"the header names a source of {len(source)} characters, {MAX_SOURCE} are allowed"
        )


def _watermark_time(head: list[Any], surplus: int) -> int:
    if len(head) != 2 or type(head[1]) is not int or not is_watermark(head[1]) or surplus:
        raise InvalidMessage(f"the watermark {str(head)[:80]} is not one number in its range")
    return head[1]
