"""The way from taps to the page: packets in a private folder, dropped where the page does not take them.

Sequenced packets and no datagrams: of those the kernel holds ten for a receiver, whoever sends them.
"""

from __future__ import annotations

import socket
from pathlib import Path

from followspot.messages import Message
from followspot.wire import pack

SOCKET = "previews"
MAX_PACKET = 190_000
"""Largest preview, bytes; sockets take a little more."""
_SEPARATOR = b"\0"


class Line:
    """The sending end. Raises OSError where no page listens in the folder."""

    def __init__(self, folder: Path) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.setblocking(False)
        try:
            self._socket.connect(str(folder / SOCKET))
        except OSError:
            self._socket.close()
            raise
        self.dropped = 0

    def send(self, port: str, message: Message) -> None:
        """Send a message of a port, or drop it: nobody waits for a page. Raises EOFError when it is gone."""
        head = _SEPARATOR.join((port.encode(), type(message).__name__.encode(), b""))
        data = head + pack(message)
        try:
            if len(data) > MAX_PACKET:
                raise OSError("too large")
            self._socket.send(data)
        except (BrokenPipeError, ConnectionResetError):
            raise EOFError("the page is gone") from None
        except OSError:
            self.dropped += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def read(data: bytes) -> tuple[str, str, bytes]:
    """Port, name of the message type and packed message of a packet. Raises ValueError."""
    port, kind, packed = data.split(_SEPARATOR, 2)
    return port.decode(), kind.decode("ascii"), packed
