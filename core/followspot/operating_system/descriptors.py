"""File descriptors that travel between processes over sockets."""

from __future__ import annotations

import errno
import socket
import time
from collections.abc import Sequence

_PATIENCE = 10.0
"""Seconds in which processes take some of the descriptors that are on their way to them."""
_PAUSE = 0.01
"""Seconds between two attempts."""


def crowded(error: OSError) -> bool:
    """True if more descriptors of this user are on their way than a process may have open (`ulimit -n`).

    The socket is sound, and takes the descriptors once some of the others have arrived.
    """
    return error.errno == errno.ETOOMANYREFS


def send_descriptors(sock: socket.socket, data: bytes, descriptors: Sequence[int]) -> int:
    """Send descriptors with bytes through a blocking socket; return how many bytes were sent.

    Waits while too many descriptors are on their way. Raises OSError.
    """
    deadline = time.monotonic() + _PATIENCE
    while True:
        try:
            return socket.send_fds(sock, [data], list(descriptors))
        except OSError as error:
            if not crowded(error) or time.monotonic() > deadline:
                raise
        time.sleep(_PAUSE)
