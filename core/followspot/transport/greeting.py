"""Asks which program answers at an endpoint, by the first message of two Zenoh peers, over its own socket.

It is an InitSyn of Zenoh's protocol 9 (all versions 1.x), and leaves no state at the other end.
"""

from __future__ import annotations

import secrets
import socket

_PROTOCOL = 9
_INIT, _ANSWER = 0x01, 0x20
_ID_MASK = 0x1F
_PEER = 1
_ID_SIZE = 16
_HEAD = 5
"""Bytes of a message before the id: its length (2), kind, protocol, and the size of the id."""


def greeted(link: socket.socket) -> str:
    """The Zenoh id at the other end, as Zenoh writes it; "" if what answers is not Zenoh.

    link: connected, with a timeout. Raises TimeoutError if nothing comes back, OSError.
    """
    body = bytes([_INIT, _PROTOCOL, (_ID_SIZE - 1) << 4 | _PEER]) + secrets.token_bytes(_ID_SIZE)
    link.sendall(len(body).to_bytes(2, "little") + body)
    head = _read(link, _HEAD)
    if len(head) < _HEAD or head[2] & (_ID_MASK | _ANSWER) != _INIT | _ANSWER or head[3] != _PROTOCOL:
        return ""
    return f"{int.from_bytes(_read(link, (head[4] >> 4) + 1), 'little'):x}"


def _read(link: socket.socket, size: int) -> bytes:
    """So many bytes, or fewer if the other end closes before."""
    data = b""
    while len(data) < size and (more := link.recv(size - len(data))):
        data += more
    return data
