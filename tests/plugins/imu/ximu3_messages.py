"""Messages of an x-IMU3 as its manual says them."""

from __future__ import annotations

import struct


def binary(letter: str, time: int, *numbers: float) -> bytes:
    """A binary message as the manual says it, with its byte stuffing and its line feed."""
    plain = struct.pack(f"<BQ{len(numbers)}f", 0x80 + ord(letter), time, *numbers)
    return plain.replace(b"\xdb", b"\xdb\xdd").replace(b"\x0a", b"\xdb\xdc") + b"\x0a"
