"""Access to the page: only browsers that were given its address, never through a page of another site."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

from starlette.responses import PlainTextResponse

from followspot_page.address import is_address

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Any]]
Send = Callable[[Any], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'"
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


class SameOriginGuard:
    """Refuses requests that come by way of another site.

    The Host check refuses foreign names that resolve here; the Origin check refuses pages of other sites.
    port: of this page; names: host names that the page may be called by besides addresses.
    """

    def __init__(self, app: App, port: int, names: frozenset[str]) -> None:
        self.app = app
        self.port = port
        self.names = names

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on or refuse it; scopes other than HTTP and WebSocket pass."""
        if scope["type"] in ("http", "websocket") and not self._welcome(scope):
            if scope["type"] == "websocket":
                await receive()
                await send({"type": "websocket.close", "code": 1008})
                return
            await PlainTextResponse("This page is not meant for other sites.\n", 403)(scope, receive, send)
            return
        await self.app(scope, receive, send)

    def _welcome(self, scope: Scope) -> bool:
        headers = {name.lower(): value.decode("latin-1") for name, value in scope["headers"]}
        host = headers.get(b"host", "")
        origin = headers.get(b"origin")
        return self._known(host) and (origin is None or origin == f"http://{host}")

    def _known(self, host: str) -> bool:
        """True if a Host header names this page: an address, or one of its names."""
        try:
            parts = urlsplit(f"//{host}")
            name, port = parts.hostname or "", parts.port or 80
        except ValueError:
            return False
        return port == self.port and (name in self.names or is_address(name))
