"""The newest of each thing that the page shows, each with the number of the change that brought it."""

from __future__ import annotations

import asyncio
import json
import socket
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from followspot.messages import InvalidMessage, Message
from followspot.room import Room
from followspot.wire import unpack
from followspot_dashboard.line import read
from followspot_dashboard.picture import Picture
from followspot_page.views import KINDS, view

MAX_THINGS = 4096
"""Largest number of different things."""
_BURST = 64
"""Packets read from one sender at a time, so that browsers are served in between."""
_BUFFER = 1 << 18
_BACKLOG = 1024
"""Connections of taps that may wait for acceptance."""


class Feed:
    """The newest of each thing, ready for browsers; a slow browser misses intermediate versions."""

    def __init__(self) -> None:
        self.number = 0
        self.things: dict[str, tuple[int, str | bytes]] = {}
        self.listeners: set[asyncio.Event] = set()
        """Set at every change; one for each waiting browser."""

    def put(self, key: str, payload: str | bytes) -> None:
        """Replace a thing."""
        if key in self.things or len(self.things) < MAX_THINGS:
            self.number += 1
            self.things[key] = (self.number, payload)
            for listener in self.listeners:
                listener.set()

    def newest(self, key: str) -> str | bytes | None:
        """The thing as it is now."""
        return self.things.get(key, (0, None))[1]

    def since(self, number: int) -> list[str | bytes]:
        """Things that changed after a change number, oldest first."""
        newer = sorted((n, key) for key, (n, _) in self.things.items() if n > number)
        return [self.things[key][1] for _, key in newer]


class Previews:
    """Turns packets of taps into things to show. watch: receives every message except pictures."""

    def __init__(self, feed: Feed, room: Room, watch: Callable[[Message], None]) -> None:
        self.feed = feed
        self.room = room
        self.watch = watch
        self.invalid = 0

    def take_from(self, sender: str, packet: bytes) -> None:
        """Show what a port on another host sent; a host may send for its own ports only."""
        if packet.startswith(sender.encode() + b"\0"):
            self.take(packet)
        else:
            self.invalid += 1

    def take(self, packet: bytes) -> None:
        """Show a packet; a malformed one is counted and dropped."""
        try:
            port, name, packed = read(packet)
            message = unpack(packed, KINDS[name])
            if isinstance(message, Picture):
                self.feed.put(f"picture {message.camera}", picture_bytes(message))
            elif isinstance(message, Message):
                self.watch(message)
                data = {"type": "view", "port": port, **view(message, self.room)}
                self.feed.put(f"view {port}", json.dumps(data, separators=(",", ":")))
        except (InvalidMessage, ValueError, KeyError, IndexError):
            self.invalid += 1


def picture_bytes(picture: Picture) -> bytes:
    """A picture for the browser: length of the camera's name, the name, width, height, ms, the JPEG."""
    name = picture.camera.encode()[:255]
    head = struct.pack("<B", len(name)) + name
    head += struct.pack("<HHd", picture.width & 0xFFFF, picture.height & 0xFFFF, picture.header.time / 1e6)
    return head + picture.jpeg.tobytes()


class Listener:
    """Receives the packets of all senders that connect to this socket, in the running event loop."""

    def __init__(self, path: Path, take: Callable[[bytes], Any]) -> None:
        """Raises OSError."""
        self._take = take
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._listener.setblocking(False)
        self._listener.bind(str(path))
        self._listener.listen(_BACKLOG)
        self._senders: set[socket.socket] = set()
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._listener, self._admit)

    def close(self) -> None:
        """Close all connections."""
        for end in (self._listener, *self._senders):
            self._loop.remove_reader(end)
            end.close()

    def _admit(self) -> None:
        sender, _ = self._listener.accept()
        sender.setblocking(False)
        self._senders.add(sender)
        self._loop.add_reader(sender, self._hear, sender)

    def _hear(self, sender: socket.socket) -> None:
        for _ in range(_BURST):
            try:
                packet = sender.recv(_BUFFER)
            except BlockingIOError:
                return
            except OSError:
                packet = b""
            if not packet:
                self._loop.remove_reader(sender)
                self._senders.discard(sender)
                sender.close()
                return
            self._take(packet)
