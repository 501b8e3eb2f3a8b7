"""What the page knows: the newest of each thing, each with the number of the change that brought it."""

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
"""Different things that are kept."""
_BURST = 64
"""Datagrams taken in one go, so that browsers are served in between."""
_BUFFER = 1 << 18


class Feed:
    """The newest of each thing, ready to be sent to browsers; whoever is slow misses what came between."""

    def __init__(self) -> None:
        self.number = 0
        self.things: dict[str, tuple[int, str | bytes]] = {}
        self.listeners: set[asyncio.Event] = set()
        """Set at every change; of those who wait for one."""

    def put(self, key: str, payload: str | bytes) -> None:
        """A thing is new; what it was before is forgotten."""
        if key in self.things or len(self.things) < MAX_THINGS:
            self.number += 1
            self.things[key] = (self.number, payload)
            for listener in self.listeners:
                listener.set()

    def since(self, number: int) -> list[str | bytes]:
        """What is newer than a change, oldest first."""
        newer = sorted((n, key) for key, (n, _) in self.things.items() if n > number)
        return [self.things[key][1] for _, key in newer]


class Previews:
    """Turns datagrams of taps into things to show. watch: gets every message that is none of pictures."""

    def __init__(self, feed: Feed, room: Room, watch: Callable[[Message], None]) -> None:
        self.feed = feed
        self.room = room
        self.watch = watch
        self.invalid = 0

    def take(self, datagram: bytes) -> None:
        """Show what a datagram holds; what is no preview is counted and passed over."""
        try:
            port, name, packed = read(datagram)
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


def listen(path: Path, take: Callable[[bytes], Any]) -> socket.socket:
    """Take datagrams that come to a socket of this name, in the running event loop. Raises OSError."""
    receiver = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    receiver.setblocking(False)
    receiver.bind(str(path))

    def readable() -> None:
        for _ in range(_BURST):
            try:
                take(receiver.recv(_BUFFER))
            except BlockingIOError:
                return

    asyncio.get_running_loop().add_reader(receiver, readable)
    return receiver
