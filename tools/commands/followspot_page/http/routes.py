"""The web server of a page: its routes, its socket, and the end of the process that asked for it."""

from __future__ import annotations

import asyncio
import logging
import os
import socket
import sys
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket

from followspot_page import metrics
from followspot_page.bundle import MISSING, STATIC, is_bundled
from followspot_page.connections import Rejections
from followspot_page.http.access import HEADERS, SameOriginGuard
from followspot_page.http.browser import serve_browser
from followspot_page.page import Page

MAX_HEARD = 4096
"""Longest message of a browser, bytes: the figures that it plots."""
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
        text = metrics.text(page.run, page.targets, page.browsers, page.connections.refused)
        return Response(text, media_type=metrics.CONTENT_TYPE, headers=HEADERS)

    async def status(_: Request) -> Response:
        return JSONResponse(page.run.data(), headers=HEADERS)

    async def runs(_: Request) -> Response:
        if page.runs is None:
            return PlainTextResponse("This page tells nothing of other runs.\n", 404, headers=HEADERS)
        return JSONResponse(await asyncio.to_thread(page.runs.data), headers=HEADERS)

    async def viewer(socket: WebSocket) -> None:
        await serve_browser(page, socket)

    return Starlette(
        routes=[
            Route("/", home),
            Route("/metrics", figures),
            Route("/status", status),
            Route("/runs", runs),
            WebSocketRoute("/look", viewer),
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


def server_of(page: Page, host: str, port: int) -> uvicorn.Server:
    """The server of a page at this address."""
    names = frozenset({"localhost", host, socket.gethostname()})
    http, viewers = page.connections.protocols()
    config = uvicorn.Config(
        SameOriginGuard(application(page), port, names),
        log_level="warning",
        access_log=False,
        http=http,
        ws=viewers,
        ws_max_size=MAX_HEARD,
        ws_ping_interval=20.0,
        timeout_graceful_shutdown=1,
        backlog=_ACCEPTED,
        lifespan="off",
    )
    logging.getLogger("uvicorn.error").addFilter(Rejections(page.connections))
    return uvicorn.Server(config)


def listening_socket(host: str, port: int, *, firm: bool) -> socket.socket:
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


def input_over() -> asyncio.Future[bytes]:
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
