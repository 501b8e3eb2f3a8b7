"""The page's process: `python -m followspot_page.server FOLDER`, until its standard input ends.

It shows what comes to it and never asks for anything, so nothing that happens here reaches the graph.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import socket
import sys
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from followspot.graph.plan import Plan
from followspot.graph.ship import plan_from_data
from followspot_dashboard.gate import Gate, make_gate
from followspot_dashboard.line import SOCKET
from followspot_page import metrics
from followspot_page.access import HEADERS, Doorkeeper
from followspot_page.feed import Feed, Listener, Previews
from followspot_page.picture_of_run import RunPicture, status_from_data
from followspot_page.scene import scene
from followspot_page.taps import without_taps

STATIC = Path(__file__).parent / "static"
ORDER, STATUS = "order.json", "status"
MAX_BROWSERS = 16
MAX_HEARD = 1024
"""Longest message taken from a browser, bytes; the page has nothing to say."""
_PATIENCE = 30.0
"""Seconds that a browser may take for one thing before it is let go."""
_PERIOD = 0.5
"""Seconds between two pictures of the run."""


class Page:
    """What the page's process knows, and who looks on."""

    def __init__(self, plan: Plan, gate: Gate) -> None:
        self.plan = plan
        self.gate = gate
        self.feed = Feed()
        self.run = RunPicture(plan)
        self.targets = metrics.Targets(plan.room)
        self.previews = Previews(self.feed, plan.room, self.targets.take)
        self.browsers = 0
        self.feed.put("scene", json.dumps({"type": "scene", **self.about()}))

    def about(self) -> dict[str, Any]:
        """What does not change during a run."""
        return {
            "graph": self.plan.graph,
            "room": scene(self.plan.room),
            "stages": [
                {"name": s.name, "group": s.group, "uses": s.uses, "params": dict(s.params)}
                for s in self.plan.stages
                if without_taps(s.name)
            ],
        }

    def take_status(self, data: bytes) -> None:
        """A status of the run; what is none is passed over."""
        with contextlib.suppress(ValueError):
            self.run.take(status_from_data(data))

    async def tell_status(self) -> None:
        """Show the run as it is, now and then."""
        while True:
            self.feed.put("run", json.dumps(self.run.data()))
            await asyncio.sleep(_PERIOD)

    async def look(self, socket: WebSocket) -> None:
        """Serve one browser until it leaves, or does not take what it is sent."""
        if self.browsers >= MAX_BROWSERS:
            await socket.close(1013)
            return
        await socket.accept()
        self._count(1)
        leaving = asyncio.ensure_future(_left(socket))
        try:
            await self._send_all(socket, leaving)
        except (WebSocketDisconnect, RuntimeError, TimeoutError):
            return  # it has left while it was sent something, or does not listen
        finally:
            self._count(-1)
            leaving.cancel()

    async def _send_all(self, socket: WebSocket, leaving: asyncio.Future[None]) -> None:
        """Send the newest of each thing, as fast as the browser takes it and no faster."""
        changed = asyncio.Event()
        changed.set()
        sent = 0
        self.feed.listeners.add(changed)
        try:
            while not leaving.done():
                waiting = asyncio.ensure_future(changed.wait())
                await asyncio.wait((waiting, leaving), return_when=asyncio.FIRST_COMPLETED)
                waiting.cancel()
                changed.clear()
                number = self.feed.number
                for payload in self.feed.since(sent):
                    async with asyncio.timeout(_PATIENCE):
                        if isinstance(payload, str):
                            await socket.send_text(payload)
                        else:
                            await socket.send_bytes(payload)
                sent = number
        finally:
            self.feed.listeners.discard(changed)

    def _count(self, change: int) -> None:
        self.browsers += change
        self.gate.watched = self.browsers > 0


async def _left(socket: WebSocket) -> None:
    """Done when a browser has left; what it says until then is not listened to."""
    while (await socket.receive())["type"] != "websocket.disconnect":
        continue


def application(page: Page) -> Starlette:
    """The routes of a page."""

    async def home(_: Request) -> Response:
        return FileResponse(STATIC / "index.html", headers=HEADERS)

    async def figures(_: Request) -> Response:
        text = metrics.text(page.run, page.targets, page.browsers)
        return Response(text, media_type=metrics.CONTENT_TYPE, headers=HEADERS)

    async def status(_: Request) -> Response:
        return JSONResponse(page.run.data(), headers=HEADERS)

    return Starlette(
        routes=[
            Route("/", home),
            Route("/metrics", figures),
            Route("/status", status),
            WebSocketRoute("/look", page.look),
            Mount("/static", _Static(directory=STATIC)),
        ]
    )


class _Static(StaticFiles):
    """Files of the page, with its headers."""

    def file_response(self, *args: Any, **named: Any) -> Response:
        """As the base, and what browsers may do with it."""
        response = super().file_response(*args, **named)
        response.headers.update(HEADERS)
        return response


async def serve(folder: Path) -> None:
    """Serve the page of a folder until standard input ends. Raises OSError where the address is taken."""
    order = json.loads((folder / ORDER).read_bytes())
    page = Page(plan_from_data(order["plan"]), make_gate(folder))
    door = _door(order["host"], order["port"], firm=order["firm"])
    door.listen()  # so that whoever is told of the port is not refused
    port = door.getsockname()[1]
    app = Doorkeeper(application(page), port, frozenset({"localhost", order["host"], socket.gethostname()}))
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            log_level="error",
            ws="websockets-sansio",
            ws_max_size=MAX_HEARD,
            ws_ping_interval=20.0,
            timeout_graceful_shutdown=1,
            limit_concurrency=4 * MAX_BROWSERS,
            lifespan="off",
        )
    )
    listeners = [
        Listener(folder / SOCKET, page.previews.take),
        Listener(folder / STATUS, page.take_status),
    ]
    telling = asyncio.ensure_future(page.tell_status())
    async with _until_input_ends(server):
        print(port, flush=True)
        await server.serve([door])
    telling.cancel()
    for listener in listeners:
        listener.close()


def _door(host: str, port: int, *, firm: bool) -> socket.socket:
    """A socket at this address; at any free port where it is taken and not firm. Raises OSError."""
    door = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    door.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        door.bind((host, port))
    except OSError:
        if firm:
            raise
        door.bind((host, 0))
    return door


@contextlib.asynccontextmanager
async def _until_input_ends(server: uvicorn.Server) -> AsyncIterator[None]:
    """The run holds the other end: whatever ends it, ends the page."""

    def ended() -> None:
        if not os.read(sys.stdin.fileno(), 1):
            server.should_exit = True
            asyncio.get_running_loop().remove_reader(sys.stdin)

    asyncio.get_running_loop().add_reader(sys.stdin, ended)
    yield


def main() -> int:
    """Entry of the process."""
    try:
        asyncio.run(serve(Path(sys.argv[1])))
    except OSError as error:
        print(f"error {error.strerror or error}", flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
