"""Messages of the x-IMU3 by x-io Technologies, after its user manual v1.7, "Communication protocol".

A message ends with a line feed. An ASCII message is a letter, the time in us and numbers, with commas
between. A binary one is the letter plus 0x80, the time as uint64 and floats, little-endian, in which two
bytes stand for each line feed, as SLIP (RFC 1055) does it.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator
from typing import NamedTuple

NUMBERS = {"I": 6, "M": 3}
"""How many numbers a kind has: inertial (gyroscope in deg/s, accelerometer in g), magnetometer."""
ERROR = "F"
LONGEST = 4096
"""Longest message, bytes."""
LATEST = 1 << 52
"""Largest time, us; the device's begins when it is switched on."""
END, ESCAPE, ESCAPED_END, ESCAPED_ESCAPE = b"\x0a", b"\xdb", b"\xdb\xdc", b"\xdb\xdd"
_WRONG_ESCAPE = re.compile(rb"\xdb(?![\xdc\xdd])")


class Malformed(ValueError):
    """Bytes that are no message; the text says why."""


class Ximu3Message(NamedTuple):
    """letter: its kind; time: us; numbers: of a kind in `NUMBERS`; text: of an error."""

    letter: str
    time: int = 0
    numbers: tuple[float, ...] = ()
    text: str = ""


class Ximu3Stream:
    """Divides datagrams into messages; a message may begin in one and end in the next."""

    def __init__(self) -> None:
        self._begun = b""

    def messages(self, data: bytes) -> Iterator[Ximu3Message | Malformed]:
        """Messages of all kinds that end in a datagram, and the reasons why others cannot be read."""
        begun = self._begun
        *ended, self._begun = data.split(END)
        if not ended:
            self._begun = begun + self._begun
            if len(self._begun) > LONGEST:
                self._begun = b""
                yield Malformed(f"{LONGEST} bytes without a line feed")
            return
        for number, own in enumerate(ended):
            found = _tried(begun + own if number == 0 else own)
            yield found
            if number == 0 and begun and isinstance(found, Malformed):
                again = _tried(own)  # the datagram between may be lost, and this message whole
                if not isinstance(again, Malformed):
                    yield again


def _tried(data: bytes) -> Ximu3Message | Malformed:
    try:
        return message(data)
    except Malformed as error:
        return error


def message(data: bytes) -> Ximu3Message:
    """The message in bytes without their line feed. Raises Malformed."""
    first = data[:1]
    if not first or len(data) > LONGEST:
        raise Malformed("an empty message" if not first else f"a message of {len(data)} bytes")
    if first in b"{^":  # commands, and messages of devices behind this one
        return Ximu3Message(first.decode())
    letter = chr(first[0] & 0x7F)
    if not "A" <= letter <= "Z":
        raise Malformed(f"no message begins with 0x{first.hex()}")
    binary = first[0] >= 0x80
    if letter == ERROR:
        said = data[9:] if binary else data[1:].rpartition(b",")[2]
        return Ximu3Message(letter, text=said[:200].decode("ascii", "replace").strip())
    if letter not in NUMBERS:
        return Ximu3Message(letter)
    time, numbers = _binary(data, NUMBERS[letter]) if binary else _ascii(data, NUMBERS[letter])
    if not 0 <= time <= LATEST or not all(map(math.isfinite, numbers)):
        raise Malformed("a time or a number out of range")
    return Ximu3Message(letter, time, numbers)


def _binary(data: bytes, count: int) -> tuple[int, tuple[float, ...]]:
    if _WRONG_ESCAPE.search(data):
        raise Malformed("an escape that stands for no byte")
    plain = data.replace(ESCAPED_END, END).replace(ESCAPED_ESCAPE, ESCAPE)
    if len(plain) != 9 + 4 * count:
        raise Malformed(f"{len(plain)} bytes where {9 + 4 * count} are due")
    time, *numbers = struct.unpack(f"<xQ{count}f", plain)
    return time, tuple(numbers)


def _ascii(data: bytes, count: int) -> tuple[int, tuple[float, ...]]:
    words = data.rstrip(b"\r").split(b",")[1:]
    if len(words) != 1 + count:
        raise Malformed(f"{len(words)} values where {1 + count} are due")
    try:
        return int(words[0]), tuple(map(float, words[1:]))
    except ValueError:
        raise Malformed("a value that is no number") from None
