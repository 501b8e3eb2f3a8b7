"""Action commands of GigE Vision: one datagram, upon which all cameras that know its keys act at once."""

from __future__ import annotations

import socket
import struct
import time

PORT = 3956
"""Of cameras, for control (GVCP)."""
KEY, ANSWERED = 0x42, 0x01
ACTION, ACKNOWLEDGED = 0x0100, 0x0101
Keys = tuple[int, int, int]
"""Device key, group key, group mask."""


def send_action(keys: Keys, receiver: str, number: int, wait: float) -> int:
    """Send a command; how many cameras acknowledge it within `wait`, s, none if that is 0.

    receiver: address of a camera, or of all of a network; number: from 1 to 65535, another one each time.
    Raises OSError.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
        port.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        flags = ANSWERED if wait else 0
        port.sendto(struct.pack(">BBHHHIII", KEY, flags, ACTION, 12, number, *keys), (receiver, PORT))
        return _acknowledgements(port, number, wait) if wait else 0


def _acknowledgements(port: socket.socket, number: int, wait: float) -> int:
    senders = set()
    end = time.monotonic() + wait
    while (left := end - time.monotonic()) > 0:
        port.settimeout(left)
        try:
            answer, sender = port.recvfrom(2048)
        except TimeoutError:
            break
        if len(answer) >= 8:
            status, kind, _, answered = struct.unpack_from(">HHHH", answer)
            if (status, kind, answered) == (0, ACKNOWLEDGED, number):
                senders.add(sender)
    return len(senders)
