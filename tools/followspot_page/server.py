"""The page's process: `python -m followspot_page.server ORDER`, the arguments of `serve` as JSON."""

from __future__ import annotations

import asyncio
import json
import os
import socket
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from followspot.deploy.status import RunStatus
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot_dashboard.gate import Gate, make_gate
from followspot_dashboard.line import SOCKET
from followspot_page import metrics
from followspot_page.access import HEADERS, Doorkeeper
from followspot_page.feed import Feed, Listener, Previews
from followspot_page.follow import follow, found, look, plan_of
from followspot_page.picture_of_run import RunPicture
from followspot_page.scene import scene

STATIC = Path(__file__).parent / "static"
MAX_BROWSERS = 16
MAX_HEARD = 1024
"""Longest message taken from a browser, bytes; the page has nothing to say."""
_PATIENCE = 30.0
"""Seconds that a browser may take for one thing before it is let go."""


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
        self.show(plan)

    def show(self, plan: Plan) -> None:
        """The plan as it is now; browsers are told where it differs."""
        self.plan = self.run.plan = plan
        scene = json.dumps({"type": "scene", **self.about()})
        if self.feed.newest("scene") != scene:
            self.feed.put("scene", scene)

    def about(self) -> dict[str, Any]:
        """What does not change during a run."""
        return {
            "graph": self.plan.graph,
            "room": scene(self.plan.room),
            "stages": [
                {"name": s.name, "group": s.group, "uses": s.uses, "params": dict(s.params)}
                for s in self.plan.stages
            ],
        }

    def take_status(self, status: RunStatus) -> None:
        """How the run is now."""
        self.run.take(status)
        self.feed.put("run", json.dumps(self.run.data()))

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


async def serve(host: str, port: int, *, firm: bool, pid: int, rate: float) -> None:
    """Serve the page of a process's run until that ends, or standard input.

    firm: whether another port will not do where this one is taken. Raises OSError where the address cannot
    be had, FollowspotError where the run does not let itself be looked at.
    """
    with TemporaryDirectory(prefix="followspot-page-") as made:
        folder = Path(made)
        door = _door(host, port, firm=firm)
        door.listen()  # who comes before the run has begun waits, and is not refused
        print(door.getsockname()[1], flush=True)
        over = _input_over()
        waiting = asyncio.ensure_future(found(pid))
        await asyncio.wait((waiting, over), return_when=asyncio.FIRST_COMPLETED)
        if over.done():
            waiting.cancel()
            return
        run = waiting.result()
        page = Page(await plan_of(run), make_gate(folder))
        listener = Listener(folder / SOCKET, page.previews.take)
        await look(run, page.plan, folder, rate)
        server = _server(page, host, door.getsockname()[1])
        serving = asyncio.ensure_future(server.serve([door]))
        following = asyncio.ensure_future(follow(run, page.take_status, page.show))
        await asyncio.wait((serving, following, over), return_when=asyncio.FIRST_COMPLETED)
        server.should_exit = True
        await serving
        following.cancel()
        listener.close()


def _server(page: Page, host: str, port: int) -> uvicorn.Server:
    names = frozenset({"localhost", host, socket.gethostname()})
    config = uvicorn.Config(
        Doorkeeper(application(page), port, names),
        log_level="error",
        ws="websockets-sansio",
        ws_max_size=MAX_HEARD,
        ws_ping_interval=20.0,
        timeout_graceful_shutdown=1,
        limit_concurrency=4 * MAX_BROWSERS,
        lifespan="off",
    )
    return uvicorn.Server(config)


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


def _input_over() -> asyncio.Future[None]:
    """Done when standard input ends: whoever started the page holds the other end."""
    loop = asyncio.get_running_loop()
    over: asyncio.Future[None] = loop.create_future()

    def readable() -> None:
        if not os.read(sys.stdin.fileno(), 1):
            loop.remove_reader(sys.stdin)
            over.set_result(None)

    loop.add_reader(sys.stdin, readable)
    return over


def main() -> int:
    """Entry of the process."""
    try:
        asyncio.run(serve(**json.loads(sys.argv[1])))
    except (OSError, FollowspotError) as error:
        print(f"error {getattr(error, 'strerror', None) or error}", flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
