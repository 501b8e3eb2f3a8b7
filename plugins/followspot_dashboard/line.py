"""Connections from taps to the page: packets over a socket in a private folder, dropped if the page is busy.

The sockets carry sequenced packets, not datagrams, because the kernel queues only ten datagrams a receiver.
"""

from __future__ import annotations

import socket
from pathlib import Path

from followspot.messages import Message
from followspot.stage import Context, Post
from followspot.wire import pack
from followspot_dashboard.gate import Gate

SOCKET = "previews"
MAX_PACKET = 190_000
"""Largest preview, bytes; sockets take a little more."""
_SEPARATOR = b"\0"


class Line:
    """The sending end, and the page's gate. Raises OSError if no page is in the folder."""

    def __init__(self, folder: Path) -> None:
        self.gate = Gate(folder)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.setblocking(False)
        try:
            self._socket.connect(str(folder / SOCKET))
        except OSError:
            self._socket.close()
            self.gate.close()
            raise
        self.dropped = 0

    @property
    def watched(self) -> bool:
        """Whether a browser shows pictures."""
        return self.gate.watched

    @property
    def deserted(self) -> bool:
        """Never: :meth:`send` raises instead."""
        return False

    def send(self, port: str, message: Message) -> None:
        """Send a message of a port, or drop it if the page is busy. Raises EOFError if the page has ended."""
        data = packet(port, message)
        try:
            if len(data) > MAX_PACKET:
                raise OSError("too large")
            self._socket.send(data)
        except (BrokenPipeError, ConnectionResetError):
            raise EOFError("the page has ended") from None
        except OSError:
            self.dropped += 1

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()
        self.gate.close()


class PostLine:
    """The sending end on another host than the page's."""

    def __init__(self, post: Post) -> None:
        self._post = post
        self._looked_at = False

    @property
    def watched(self) -> bool:
        """Whether a reader is there."""
        self._looked_at |= self._post.wanted
        return self._post.wanted

    @property
    def deserted(self) -> bool:
        """Whether the last reader has left."""
        return not self.watched and self._looked_at

    def send(self, port: str, message: Message) -> None:
        """Send a message of a port, or drop it."""
        if self._post.wanted:
            self._post.send(packet(port, message))

    def close(self) -> None:
        """Send no more."""
        self._post.close()


def line_of(context: Context, folder: Path | None) -> Line | PostLine | None:
    """The connection of a tap to its reader; None if there is no reader.

    folder: of the reader's sockets, if the reader is on this host.
    """
    if folder is None:
        return PostLine(context.post) if context.post is not None else None
    try:
        return Line(folder)
    except OSError as error:
        context.warn(f"no reader answers in {folder}: {error}")
        return None


def packet(port: str, message: Message) -> bytes:
    """A packet with a message of a port."""
    return _SEPARATOR.join((port.encode(), type(message).__name__.encode(), pack(message)))


def read(data: bytes) -> tuple[str, str, bytes]:
    """Port, name of the message type and packed message of a packet. Raises ValueError."""
    port, kind, packed = data.split(_SEPARATOR, 2)
    return port.decode(), kind.decode("ascii"), packed
