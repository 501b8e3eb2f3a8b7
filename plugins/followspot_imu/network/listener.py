"""Datagrams that arrive at a port, one after the other."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

from followspot.errors import InputError, Mistake

MOST_BYTES = 65_536
RECEIVE_BUFFER = 1 << 20
"""Asked of the system, bytes: half a minute of a sensor, for a graph that is busy."""


class Datagram(NamedTuple):
    """Its bytes, its time of arrival, ns since 1970, and the address of its sender, "" if none came."""

    data: bytes
    arrival: int
    sender: str


def opened(host: str, port: int) -> socket.socket:
    """A socket that listens. host: own address. Raises InputError if that is not possible."""
    own = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        own.bind((host, port))
    except (OSError, UnicodeError) as error:
        own.close()
        text = f"cannot listen at {host}:{port}: {error}"
        remedy = "host: an address of this host, 0.0.0.0 for all; port: one that no other sensor uses"
        raise InputError([Mistake(None, text, remedy)]) from None
    return own


def datagrams(own: socket.socket, ended: Callable[[], bool], wait: float) -> Iterator[Datagram]:
    """Datagrams until it has `ended`; one without a sender if none arrives for `wait` seconds."""
    own.settimeout(wait)
    while not ended():
        try:
            data, (address, _) = own.recvfrom(MOST_BYTES)
        except TimeoutError:
            yield Datagram(b"", time.time_ns(), "")
        else:
            yield Datagram(data, time.time_ns(), address)
