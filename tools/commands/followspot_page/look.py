"""A browser that looks at the page, from its first request until it leaves."""

from __future__ import annotations

from starlette.websockets import WebSocket

from followspot_page.browser import Browser
from followspot_page.page import Page
from followspot_page.requests import Requests

_LATER = 1013
"""The code of a WebSocket that closes because its server is busy."""


async def look(page: Page, socket: WebSocket) -> None:
    """Serve one browser until it leaves or stops taking messages, or tell it why there is no room."""
    address = socket.client.host if socket.client is not None else ""
    await socket.accept()  # a browser is told nothing about a handshake that fails
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
