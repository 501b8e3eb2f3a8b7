"""Requests of a browser that opens the socket of the page, and the messages that the page sends."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from websockets.sync.client import ClientConnection

UPGRADE = """\
GET /look HTTP/1.1
Host: {host}
Upgrade: websocket
Connection: Upgrade
Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==
Sec-WebSocket-Version: 13

"""


def things(browser: ClientConnection, kind: str) -> Iterator[dict[str, Any]]:
    """What a browser is sent of a type, as long as it asks."""
    while True:
        said = browser.recv(timeout=60)
        if isinstance(said, str) and (thing := json.loads(said))["type"] == kind:
            yield thing
