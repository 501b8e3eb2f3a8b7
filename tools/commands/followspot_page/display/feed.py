"""The newest of each thing that the page shows, each with the number of the change that brought it."""

from __future__ import annotations

import asyncio
import json
import struct
import threading
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from typing import Any

from followspot.messages import InvalidMessage, Message
from followspot.room import Room
from followspot.taps.framing import Record
from followspot.wire import unpack
from followspot_dashboard.picture import Picture
from followspot_page.display.message_views import view

MAX_THINGS = 4096
"""Largest number of different things."""
_WAITING = 256
"""Previews that may wait for the page; further ones are dropped."""


class Feed:
    """The newest of each thing, ready for browsers; a slow browser misses intermediate versions."""

    def __init__(self) -> None:
        self.number = 0
        self.over = False
        """Nothing follows: browsers leave when they have read what is there."""
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

    def end(self, payload: str) -> None:
        """Put the last thing."""
        self.over = True
        self.put("end", payload)

    def newest(self, key: str) -> str | bytes | None:
        """The thing as it is now."""
        return self.things.get(key, (0, None))[1]

    def since(self, number: int) -> list[str | bytes]:
        """Things that changed after a change number, oldest first."""
        newer = sorted((n, key) for key, (n, _) in self.things.items() if n > number)
        return [self.things[key][1] for _, key in newer]


class Previews:
    """Turns packets of taps into things to show. watch: receives all but pictures, each with its port."""

    def __init__(self, feed: Feed, room: Room, watch: Callable[[str, Message], None]) -> None:
        self.feed = feed
        self.room = room
        self.watch = watch
        self.kinds: Mapping[str, type[Message]] = {}
        """Type of the messages that the tap of each port sends."""
        self.drawn: Collection[str] = ()
        """The ports whose messages are shown; of others only figures are plotted."""

    def take(self, port: str, packed: bytes) -> None:
        """Show a message, unless it is malformed: only a foreign sender makes such."""
        with suppress(InvalidMessage, ValueError, KeyError, IndexError):
            message = unpack(packed, self.kinds[port])
            if isinstance(message, Picture):
                self.feed.put(f"picture {message.camera}", picture_bytes(message))
            elif isinstance(message, Message):
                self.watch(port, message)
                if port not in self.drawn:
                    return
                data = {"type": "view", "port": port, **view(message, self.room)}
                self.feed.put(f"view {port}", json.dumps(data, separators=(",", ":")))


def picture_bytes(picture: Picture) -> bytes:
    """A picture for the browser: length of the camera's name, the name, width, height, ms, the JPEG."""
    name = picture.camera.encode()[:255]
    head = struct.pack("<B", len(name)) + name
    head += struct.pack("<HHd", picture.width & 0xFFFF, picture.height & 0xFFFF, picture.header.time / 1e6)
    return head + picture.jpeg.tobytes()


class Arrivals:
    """Hands what threads receive to the running event loop; what comes while too much waits is dropped."""

    def __init__(self, take: Callable[[str, bytes], Any]) -> None:
        """take: receives a port, and a packed message of it."""
        self._take = take
        self._loop = asyncio.get_running_loop()
        self._room = threading.Semaphore(_WAITING)

    def consume(self, records: Iterator[Record]) -> None:
        """Take what one sender brings, until it leaves; safe in any thread."""
        with suppress(ValueError, RuntimeError):  # a malformed stream; the loop has ended
            for port, _, packed in records:
                if self._room.acquire(blocking=False):
                    self._loop.call_soon_threadsafe(self._arrived, port, packed)

    def _arrived(self, port: str, packed: bytes) -> None:
        self._room.release()
        self._take(port, packed)
