"""The page's process: `python -m followspot_page.server ORDER`, the arguments of `serve` as JSON."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import socket
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles

from followspot.errors import FollowspotError
from followspot.taps.receivers import LocalReceiver
from followspot_dashboard.gate import SOCKET, make_gate
from followspot_page import metrics
from followspot_page.access import HEADERS, Doorkeeper
from followspot_page.address import is_loopback
from followspot_page.bundle import MISSING, STATIC, is_bundled
from followspot_page.crowd import Rejections
from followspot_page.feed import Arrivals
from followspot_page.follow import Sight, follow, found, plan_of, remote_previews
from followspot_page.page import Page

MAX_HEARD = 1024
"""Longest message of a browser, bytes: a change."""
_ACCEPTED = 64
"""Connections accepted before the first request of any: each is a file descriptor."""


async def home(_: Request) -> Response:
    """The page, or how to get it."""
    if not is_bundled():
        return PlainTextResponse(f"{MISSING}\n", 503, headers=HEADERS)
    return FileResponse(STATIC / "index.html", headers=HEADERS)


def application(page: Page) -> Starlette:
    """The routes of a page."""

    async def figures(_: Request) -> Response:
        text = metrics.text(page.run, page.targets, page.browsers, page.crowd.refused)
        return Response(text, media_type=metrics.CONTENT_TYPE, headers=HEADERS)

    async def status(_: Request) -> Response:
        return JSONResponse(page.run.data(), headers=HEADERS)

    return Starlette(
        routes=[
            Route("/", home),
            Route("/metrics", figures),
            Route("/status", status),
            WebSocketRoute("/look", page.look),
            Mount("/static", _Static(directory=STATIC, check_dir=False)),
        ]
    )


class _Static(StaticFiles):
    """Files of the page, with its headers."""

    def file_response(self, *args: Any, **named: Any) -> Response:
        """The response of the base class with headers that restrict browsers."""
        response = super().file_response(*args, **named)
        response.headers.update(HEADERS)
        return response


async def serve(host: str, port: int, *, firm: bool, pid: int, rate: float) -> None:
    """Serve the page of a process's run until the run or standard input ends.

    firm: no other port may replace a taken one. Raises OSError if the address cannot be bound,
    FollowspotError if the run refuses taps.
    """
    with TemporaryDirectory(prefix="followspot-page-") as made:
        folder = Path(made)
        endpoint = _listening_socket(host, port, firm=firm)
        endpoint.listen()  # browsers that connect before the run has begun wait
        print(endpoint.getsockname()[1], flush=True)
        over = _input_over()
        waiting = asyncio.ensure_future(found(pid))
        await asyncio.wait((waiting, over), return_when=asyncio.FIRST_COMPLETED)
        if over.done():
            waiting.cancel()
            return
        run = waiting.result()
        page = Page(await plan_of(run), make_gate(folder), folder)
        receiver = LocalReceiver(folder / SOCKET, Arrivals(page.previews.take).hear)
        page.remote = await remote_previews(run, page.previews.take)
        sight = Sight(run, folder, rate, page.remote)
        await sight.turn_to(page.plan)
        server = _server(page, host, endpoint.getsockname()[1])
        serving = asyncio.ensure_future(server.serve([endpoint]))
        following = asyncio.ensure_future(follow(run, sight, page.take_status, page.show))
        if is_loopback(host):
            await page.allow_changes(run)
        await asyncio.wait((serving, following, over), return_when=asyncio.FIRST_COMPLETED)
        if following.done():
            await page.end("over or gone")
        elif over.done() and over.result():
            await page.end("ended")
        server.should_exit = True
        await serving
        following.cancel()
        await sight.close()
        await page.button.close()
        receiver.close()
        if page.remote is not None:
            page.remote.close()


def _server(page: Page, host: str, port: int) -> uvicorn.Server:
    names = frozenset({"localhost", host, socket.gethostname()})
    http, look = page.crowd.protocols()
    config = uvicorn.Config(
        Doorkeeper(application(page), port, names),
        log_level="warning",
        access_log=False,
        http=http,
        ws=look,
        ws_max_size=MAX_HEARD,
        ws_ping_interval=20.0,
        timeout_graceful_shutdown=1,
        backlog=_ACCEPTED,
        lifespan="off",
    )
    logging.getLogger("uvicorn.error").addFilter(Rejections(page.crowd))
    return uvicorn.Server(config)


def _listening_socket(host: str, port: int, *, firm: bool) -> socket.socket:
    """A socket at this address, or at a free port if it is taken and not firm. Raises OSError."""
    endpoint = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    endpoint.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        endpoint.bind((host, port))
    except OSError:
        if firm:
            raise
        endpoint.bind((host, 0))
    return endpoint


def _input_over() -> asyncio.Future[bytes]:
    """Done when standard input ends, which the starting process holds open; the last line read."""
    loop = asyncio.get_running_loop()
    over: asyncio.Future[bytes] = loop.create_future()
    said = b""

    def readable() -> None:
        nonlocal said
        if came := os.read(sys.stdin.fileno(), 1):
            said = came
            return
        loop.remove_reader(sys.stdin)
        over.set_result(said)

    loop.add_reader(sys.stdin, readable)
    return over


def main() -> int:
    """Entry of the process."""
    logging.getLogger("asyncio").setLevel(logging.ERROR)  # otherwise uvicorn logs browsers that left
    try:
        asyncio.run(serve(**json.loads(sys.argv[1])))
    except (OSError, FollowspotError) as error:
        print(f"error {getattr(error, 'strerror', None) or error}", flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
