"""The frame of every token on the wire: a prefix, a msgpack head, aligned bytes (docs/wire.md)."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import addressof, c_char
from struct import Struct
from typing import Any

import msgpack
import numpy as np

from followspot.messages import Array, InvalidMessage

VERSION = 1
ALIGN = 64
"""Arrays start at multiples of this many bytes: a cache line, and any vector register."""
PREFIX = Struct("<BxH")
"""Version, a byte that says how arrays are coded, size of the msgpack head in bytes."""
RAW = 0
"""The second byte of a token whose arrays stand as they are."""
MAX_HEAD = (1 << 16) - ALIGN
"""Largest msgpack head, bytes."""

_PACKER = msgpack.Packer()
"""Shared by all threads under the interpreter's lock: a new packer costs a page fault per message."""


def padded(size: int) -> int:
    """The next multiple of `ALIGN`, bytes."""
    return -(-size // ALIGN) * ALIGN


def aligned(size: int) -> Array:
    """An uninitialised (size,) uint8 array whose memory starts at a multiple of `ALIGN`."""
    memory: Any = np.empty(size + ALIGN, np.uint8)
    start = -addressof(c_char.from_buffer(memory)) % ALIGN  # a third of the time of `memory.ctypes.data`
    array: Array = memory[start : start + size]
    return array


def pack_head(fields: Sequence[Any]) -> bytes:
    """Prefix and msgpack array, padded with zeros. Raises InvalidMessage if a field cannot be sent."""
    try:
        head: bytes = _PACKER.pack(fields)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidMessage(f"cannot be sent: {error}") from None
    if len(head) > MAX_HEAD:
        raise InvalidMessage(f"the head has {len(head)} bytes, at most {MAX_HEAD} allowed")
    size = PREFIX.size + len(head)
    return PREFIX.pack(VERSION, len(head)) + head + bytes(-size % ALIGN)


def unpack_head(data: bytes | memoryview) -> tuple[list[Any], int]:
    """The fields of the head at the start of `data`, and the index of the first byte after it, in bytes.

    Raises InvalidMessage.
    """
    if len(data) < PREFIX.size:
        raise InvalidMessage(f"{len(data)} bytes are too few for a head")
    version, size = PREFIX.unpack_from(data)
    if version != VERSION:
        raise InvalidMessage(f"wire format {version}, this is {VERSION}")
    end = PREFIX.size + size
    if size > MAX_HEAD or padded(end) > len(data):
        raise InvalidMessage(f"a head of {size} bytes does not fit into {len(data)}")
    try:
        fields = msgpack.unpackb(data[PREFIX.size : end])
    except (TypeError, ValueError, OverflowError, RecursionError, msgpack.UnpackException) as error:
        raise InvalidMessage(f"the head is not msgpack: {error}") from None
    if type(fields) is not list or not fields:
        raise InvalidMessage("the head is not a list")
    return fields, padded(end)
