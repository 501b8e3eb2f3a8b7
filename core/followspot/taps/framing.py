"""A packed message with its port and number, as taps send it."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from struct import Struct

from followspot.wire import MAX_PACKED

HEAD = Struct("<IQH")
"""Before each message: its size in bytes, its number, and the length of its port's name, which follows."""

Record = tuple[str, int, bytes]
"""Port, number and packed message."""


def head_of(port: str, number: int, packed: bytes) -> bytes:
    """Bytes that precede a packed message."""
    name = port.encode()
    return HEAD.pack(len(packed), number, len(name)) + name


def framed_record(packet: bytes) -> Record | None:
    """The record of a packet that holds exactly one; None if the packet is malformed."""
    if len(packet) < HEAD.size:
        return None
    size, number, name = HEAD.unpack_from(packet)
    start = HEAD.size + name
    if len(packet) != start + size:
        return None
    return packet[HEAD.size : start].decode(errors="replace"), number, packet[start:]


def framed_records(sender: socket.socket) -> Iterator[Record]:
    """Records from a stream until the sender closes it. Raises ValueError if a record is too large."""
    while head := _exactly(sender, HEAD.size):
        size, number, name = HEAD.unpack(head)
        if size > MAX_PACKED:
            raise ValueError(f"a message of {size} bytes")
        port = _exactly(sender, name).decode()
        packed = _exactly(sender, size)
        if len(packed) < size:
            return
        yield port, number, packed


def _exactly(sender: socket.socket, size: int) -> bytes:
    """The next `size` bytes of the stream; b"" if it ends before."""
    data = bytearray(size)
    view, filled = memoryview(data), 0
    while filled < size:
        try:
            more = sender.recv_into(view[filled:])
        except OSError:
            more = 0
        if not more:
            return b""
        filled += more
    return bytes(data)
