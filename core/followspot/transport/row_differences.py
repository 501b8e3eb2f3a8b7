"""Pictures as differences between their rows, which compress better (docs/wire.md).

Neighbouring rows of a picture are alike, so that most differences are small numbers: an entropy coder such as
zstd then needs about half as many bytes (the filter "Up" of PNG, RFC 2083, section 6.4). The second byte of a
token says that its arrays are coded so. Its size stays the same, and so does every bit.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise
from math import prod
from typing import Any

import numpy as np

from followspot.messages import MAX_BYTES, Array, InvalidMessage
from followspot.transport.wire import RAW, padded, unpack_head

ROWS = 3
"""Second byte of a token whose pictures are differences of rows."""
_TYPES = ("|u1", "<u2")
"""Numbers of pictures: 8 and 16 bits."""
_DTYPE = re.compile(r"\|[biu]1|[<>][iuf][248]|[<>]c(8|16)")
_LONG = 512
"""Numbers in a row from which adding row by row is faster than all rows at once."""
_FEWEST = 1024
"""Smallest array that is worth coding, bytes."""


def differenced(data: bytes) -> bytes:
    """A packed message whose pictures are differences between their rows; itself if it has none.

    A picture is an array of uint8 or uint16 with two or three dimensions. Raises InvalidMessage.
    """
    spans = list(_pictures(data))
    if not spans or data[1] != RAW:
        return data
    made = bytearray(data)
    made[1] = ROWS
    for start, rows, kind in spans:
        _difference(_view(data, start, rows, kind), _view(made, start, rows, kind))
    return bytes(made)


def restored(data: bytes | memoryview) -> bytes | memoryview:
    """The packed message that `differenced` was given. Raises InvalidMessage."""
    if len(data) < 2 or data[1] != ROWS:
        return data
    made = bytearray(data)
    made[1] = RAW
    for start, rows, kind in _pictures(data):
        _accumulate(_view(made, start, rows, kind))
    return bytes(made)


def _difference(pixels: Array, into: Array) -> None:
    """Each row less the one above it, modulo the range of the numbers; the first one stays. (H, W * C)."""
    np.subtract(pixels[1:], pixels[:-1], out=into[1:])


def _accumulate(pixels: Array) -> None:
    """The inverse of `_difference`, in place. (H, W * C)."""
    if pixels.shape[1] < _LONG:
        np.add.accumulate(pixels, axis=0, dtype=pixels.dtype, out=pixels)
        return
    for above, row in pairwise(pixels):  # of long rows several times as fast as `accumulate`
        np.add(above, row, out=row)


def _view(data: bytes | bytearray, start: int, rows: tuple[int, int], kind: str) -> Array:
    return np.ndarray(rows, kind, data, start)


def _pictures(data: bytes | memoryview) -> Iterator[tuple[int, tuple[int, int], str]]:
    """First byte, rows and numbers in a row, and dtype of each picture. Raises InvalidMessage."""
    head, start = unpack_head(data)
    if len(head) != 7 or type(head[6]) is not list:
        return
    for column in head[6]:
        kind, shape = _dtype_and_shape(column)
        size = kind.itemsize * prod(shape)
        if size > len(data) - start:
            raise InvalidMessage(f"an array of {size} bytes does not fit into {len(data)}")
        if kind.str in _TYPES and len(shape) in (2, 3) and size >= _FEWEST:
            yield start, (shape[0], prod(shape[1:])), kind.str
        start += padded(size)


def _dtype_and_shape(column: Any) -> tuple[np.dtype[Any], tuple[int, ...]]:
    """Type and shape of a column in a head. Raises InvalidMessage."""
    if type(column) is not list or len(column) != 3 or type(column[2]) is not list:
        raise InvalidMessage(f"{str(column)[:80]} is no column")
    if any(type(size) is not int or not 0 <= size <= MAX_BYTES for size in column[2]):
        raise InvalidMessage(f"impossible shape {str(column[2])[:80]}")
    if type(column[1]) is not str or _DTYPE.fullmatch(column[1]) is None:
        raise InvalidMessage(f"{str(column[1])[:80]} is no dtype of plain numbers")
    return np.dtype(column[1]), tuple(column[2])
