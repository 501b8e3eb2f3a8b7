"""One browser: receives the newest of each thing, and may ask for changes."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Awaitable, Callable

from starlette.websockets import WebSocket, WebSocketDisconnect

from followspot.errors import FollowspotError
from followspot_page.display.feed import Feed
from followspot_page.page import Page
from followspot_page.page_process import FAREWELL
from followspot_page.requests.handler import Requests
from followspot_page.requests.reply import Reply

Do = Callable[[str], Awaitable[Reply]]
"""Carries out a browser's request. Raises FollowspotError if that fails."""
STILL = b"\0"
"""First byte of a still picture, instead of the length of a camera's name: its answer follows."""
_TIMEOUT = 30.0
"""Seconds within which a browser must take a message."""
_WAITING = 8
"""Answers that may wait for a slow browser."""
_LATER = 1013
"""The code of a WebSocket that closes because its server is busy."""


class Browser:
    """Serves one WebSocket."""

    def __init__(self, socket: WebSocket, feed: Feed, do: Do) -> None:
        self._socket = socket
        self._feed = feed
        self._do = do
        self._changed = asyncio.Event()
        self._answers: deque[str | bytes] = deque(maxlen=_WAITING)

    async def serve(self) -> None:
        """Serve until the browser leaves, stops taking messages, or the run has ended."""
        self._feed.listeners.add(self._changed)
        receiving = asyncio.ensure_future(self._receive())
        sending = asyncio.ensure_future(self._send())
        try:
            await asyncio.wait((receiving, sending), return_when=asyncio.FIRST_COMPLETED)
            if self._feed.over:  # what was sent may not have left this process yet
                await asyncio.wait((receiving,), timeout=FAREWELL)
        finally:
            self._feed.listeners.discard(self._changed)
            for task in (receiving, sending):
                task.cancel()
            await asyncio.gather(receiving, sending, return_exceptions=True)

    async def _receive(self) -> None:
        """Carry out the browser's requests in order, until it leaves."""
        while (said := await self._socket.receive())["type"] != "websocket.disconnect":
            asked = said.get("text") or ""
            try:
                reply, ok = await self._do(asked), True
            except FollowspotError as error:
                reply, ok = Reply(str(error)), False
            if reply.picture:
                self._answers.append(STILL + reply.picture)
            answer = {"text": reply.text, "ok": ok, "about": reply.about}
            self._answers.append(json.dumps({"type": "answer", "to": asked, **answer}))
            self._changed.set()

    async def _send(self) -> None:
        """Send the newest of each thing as fast as the browser takes it; answers follow their state."""
        sent = 0
        try:
            while True:
                over, number = self._feed.over, self._feed.number
                newer = [*self._feed.since(sent), *self._answers]
                self._answers.clear()
                for payload in newer:
                    async with asyncio.timeout(_TIMEOUT):
                        await self._put(payload)
                sent = number
                if over:
                    return
                await self._changed.wait()
                self._changed.clear()
        except (WebSocketDisconnect, RuntimeError, TimeoutError):
            return  # the browser left while it was sent something, or does not read

    async def _put(self, payload: str | bytes) -> None:
        if isinstance(payload, str):
            await self._socket.send_text(payload)
        else:
            await self._socket.send_bytes(payload)


async def serve_browser(page: Page, socket: WebSocket) -> None:
    """Serve one browser until it leaves or stops taking messages, or say why there is no room."""
    address = socket.client.host if socket.client is not None else ""
    await socket.accept()  # a browser learns nothing about a handshake that fails
    if reason := page.full(address):
        page.connections.refused["crowded"] += 1
        await socket.close(_LATER, reason)
        return
    page.count(address, 1)
    requests = Requests(page)
    try:
        await Browser(socket, page.feed, requests.do).serve()
    finally:
        page.count(address, -1)
        await requests.leave()
