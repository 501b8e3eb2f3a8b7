"""Connections to the page, and how long each may stay idle.

The server closes a connection that neither asks nor takes its answer in time. If many wait, the one that
waited longest makes room, so that a new browser is always served.
"""

from __future__ import annotations

import asyncio
import logging
from collections import Counter
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

MAX_WAITING = 128
"""Idle connections; if there are more, the oldest makes room."""
TIMEOUTS = {"silent": 5.0, "deaf": 60.0}
"""Seconds from a connection or its last answer to the next request, and for taking an answer."""
MAX_FRAGMENTS = 64
"""Fragments of one message of a browser."""
MAX_UNREAD = 1 << 20
"""Bytes that may wait for a browser that asks for echoes and does not read."""


_COMPLAINTS = {
    "Invalid UTF-8 sequence received from client.": "not UTF-8",
    "Invalid HTTP request received.": "not HTTP",
    "Unsupported upgrade request.": "not HTTP",
}
"""Log messages of the server about browsers, and the reasons they are counted under."""


class Connections:
    """The connections of one page, and the number of refused ones by reason."""

    def __init__(self) -> None:
        self.refused: Counter[str] = Counter()
        self._waiting: dict[asyncio.Protocol, asyncio.Transport] = {}
        """Idle connections, longest wait first."""

    def enter(self, connection: asyncio.Protocol, transport: asyncio.Transport) -> None:
        """Add an idle connection; close the oldest if there are too many."""
        self._waiting.pop(connection, None)
        self._waiting[connection] = transport
        if len(self._waiting) > MAX_WAITING:
            self.expel(next(iter(self._waiting)), "crowded")

    def leave(self, connection: asyncio.Protocol) -> None:
        """Remove a connection that was closed or became a viewer."""
        self._waiting.pop(connection, None)

    def expel(self, connection: asyncio.Protocol, reason: str) -> None:
        """Close the connection at once; what it has not read yet is lost."""
        transport = self._waiting.pop(connection, None)
        if transport is not None:
            self.refused[reason] += 1
            transport.abort()

    def protocols(self) -> tuple[type[asyncio.Protocol], type[asyncio.Protocol]]:
        """Protocol classes for HTTP and WebSockets, for the configuration of the server."""
        return type("Http", (_Http,), {"page_connections": self}), type(
            "Viewer", (_Viewer,), {"page_connections": self}
        )


class _Http(H11Protocol):
    """A connection that must ask, and take its answer, in time."""

    page_connections: Connections
    _timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as the base
        super().connection_made(transport)
        self._wait("silent")

    def connection_lost(self, exc: Exception | None) -> None:
        self._rest()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        before = self.cycle
        super().data_received(data)
        if self.cycle is not before:
            self._wait("deaf")

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._wait("silent")

    def handle_websocket_upgrade(self, event: Any) -> None:
        self._rest()
        super().handle_websocket_upgrade(event)

    def _wait(self, reason: str) -> None:
        """Restart the idle time."""
        self._rest()
        if not self.transport.is_closing():
            self.page_connections.enter(self, self.transport)
            self._timer = self.loop.call_later(TIMEOUTS[reason], self.page_connections.expel, self, reason)

    def _rest(self) -> None:
        self.page_connections.leave(self)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


class _Viewer(WebSocketsSansIOProtocol):
    """A WebSocket of a viewer."""

    page_connections: Connections

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        unread = self.transport.get_write_buffer_size()
        if len(self.frames) > MAX_FRAGMENTS or unread > MAX_UNREAD:
            self.page_connections.refused["flood"] += 1
            self.transport.abort()


class Rejections(logging.Filter):
    """Counts the server's complaints about browsers and keeps them out of the terminal."""

    def __init__(self, connections: Connections) -> None:
        super().__init__()
        self._connections = connections

    def filter(self, record: logging.LogRecord) -> bool:
        """False if the record is about a browser."""
        reason = _COMPLAINTS.get(str(record.msg))
        if reason is not None:
            self._connections.refused[reason] += 1
        return reason is None and record.levelno >= logging.ERROR
