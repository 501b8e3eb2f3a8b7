"""Fields of a message in Protocol Buffers' wire format, without its schema."""

from __future__ import annotations

Field = int | bytes
_LENGTHS = {1: 8, 5: 4}
"""Bytes of values of a fixed length, by wire type."""


def fields(data: bytes) -> dict[int, Field]:
    """Number of each field -> its value: a number, or the bytes of a text, of bytes or of a message.

    Of a field that stands twice the last one counts. Raises ValueError.
    """
    found: dict[int, Field] = {}
    at = 0
    while at < len(data):
        key, at = _number(data, at)
        kind = key & 7
        if kind == 0:
            found[key >> 3], at = _number(data, at)
            continue
        if kind == 2:
            length, at = _number(data, at)
        elif kind in _LENGTHS:
            length = _LENGTHS[kind]
        else:
            raise ValueError(f"a field of wire type {kind}")
        if at + length > len(data):
            raise ValueError("a field is longer than its message")
        value = data[at : at + length]
        found[key >> 3] = value if kind == 2 else int.from_bytes(value, "little")
        at += length
    return found


def _number(data: bytes, at: int) -> tuple[int, int]:
    """A number of 7 bits a byte, lowest first, and the place after it. Raises ValueError."""
    value = 0
    for k, byte in enumerate(data[at : at + 10]):
        value |= (byte & 0x7F) << 7 * k
        if byte < 0x80:
            return value, at + k + 1
    raise ValueError("a number has no end")
