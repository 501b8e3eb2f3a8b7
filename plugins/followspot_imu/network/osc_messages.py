"""Messages in an OSC packet (Open Sound Control specification 1.0), with limits for packets of strangers."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import NamedTuple

BUNDLE = b"#bundle\0"
DEEPEST = 4
"""Most bundles within each other."""
MOST_MESSAGES = 256
"""In a packet."""
MOST_VALUES = 64
"""In a message."""
_FIXED = {"i": ">i", "f": ">f", "h": ">q", "d": ">d", "t": ">Q"}
_SINGLE = {"T": 1.0, "F": 0.0, "N": float("nan"), "I": float("inf")}


class OscError(ValueError):
    """Bytes that are no OSC packet; the text says why."""


class OscMessage(NamedTuple):
    """values: numbers; NaN for an argument that is none."""

    address: str
    values: tuple[float, ...]


def osc_messages(packet: bytes) -> list[OscMessage]:
    """All messages of a packet, in their order. Raises OscError."""
    found: list[OscMessage] = []
    for element in _elements(packet, 0):
        found.append(_message(element))
        if len(found) > MOST_MESSAGES:
            raise OscError(f"more than {MOST_MESSAGES} messages")
    return found


def _elements(packet: bytes, depth: int) -> Iterator[bytes]:
    """The messages of a packet, as bytes."""
    if not packet.startswith(BUNDLE):
        yield packet
        return
    if depth == DEEPEST:
        raise OscError(f"more than {DEEPEST} bundles within each other")
    at = len(BUNDLE) + 8
    while at < len(packet):
        size = _size(packet, at)
        if at + 4 + size > len(packet):
            raise OscError("an element beyond the end")
        yield from _elements(packet[at + 4 : at + 4 + size], depth + 1)
        at += 4 + size


def _message(data: bytes) -> OscMessage:
    address, at = _text(data, 0)
    if not address.startswith("/"):
        raise OscError("an address that does not begin with /")
    tags, at = _text(data, at)
    if not tags.startswith(",") or len(tags) > 1 + MOST_VALUES:
        raise OscError("no types of values, or too many")
    values = []
    for tag in tags[1:]:
        value, at = _value(tag, data, at)
        values.append(value)
    return OscMessage(address, tuple(values))


def _value(tag: str, data: bytes, at: int) -> tuple[float, int]:
    """A value as a number, and where the next one begins."""
    if tag in _FIXED:
        (number,) = _unpacked(_FIXED[tag], data, at)
        return float(number), at + struct.calcsize(_FIXED[tag])
    if tag in _SINGLE:
        return _SINGLE[tag], at
    if tag in "sS":
        return float("nan"), _text(data, at)[1]
    if tag == "b":
        size = _size(data, at)
        return float("nan"), at + 4 + -(-size // 4) * 4
    if tag in "crm":
        return float("nan"), at + 4
    raise OscError(f"a value of unknown type {tag!r}")


def _text(data: bytes, at: int) -> tuple[str, int]:
    """A text that ends with a zero, and where the next thing begins: at a multiple of four."""
    end = data.find(b"\0", at)
    if end < 0:
        raise OscError("a text without an end")
    try:
        return data[at:end].decode("ascii"), end + 4 - end % 4
    except UnicodeDecodeError:
        raise OscError("a text that is not ASCII") from None


def _size(data: bytes, at: int) -> int:
    return int(_unpacked(">I", data, at)[0])


def _unpacked(form: str, data: bytes, at: int) -> tuple[float, ...]:
    try:
        return struct.unpack_from(form, data, at)
    except struct.error:
        raise OscError("a value beyond the end") from None
