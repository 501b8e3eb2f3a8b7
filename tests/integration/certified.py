"""Hosts with certificates, and an agent among them: real sessions over TLS on loopback."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

import zenoh

from followspot.control.dispatch import Dispatcher, Role, RunRequest
from followspot.control.zenoh_rpc import RpcServer
from followspot.security.request_guard import Asked, envelope
from followspot.transport.zenoh.network import Network
from followspot.transport.zenoh.session import connected

HOSTS = {"desk": "operator", "second": "operator", "pc-left": "camera", "pc-right": "camera", "hub": "router"}


@contextmanager
def session(
    folder: Path, *, listen: str = "", connect: str = "", router: str = "", routes: bool = False
) -> Iterator[zenoh.Session]:
    network = Network((listen,) if listen else (), (connect,) if connect else (), str(folder), router=router)
    opened = connected(network, routes=routes)
    try:
        yield opened
    finally:
        opened.close()  # type: ignore[no-untyped-call]


def wait_for(condition: Callable[[], bool], seconds: float = 60.0) -> bool:
    """Whether the condition comes to hold; the seconds only bound a failure."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


def met(session: zenoh.Session) -> bool:
    return wait_for(lambda: bool(session.info.links()))


class Stop(RunRequest):
    roles: ClassVar[tuple[Role, ...]] = ("host",)


class Agent:
    """An agent's guard: the requests that it answers and rejects, and the samples on all keys."""

    def __init__(self, session: zenoh.Session, name: str) -> None:
        self.stopped: list[str] = []
        self.heard: list[str] = []
        self.lines: list[str] = []
        self.session = session
        stop = Dispatcher("host", {Stop: lambda request: self.stopped.append(request.run)})
        self.answers = RpcServer(session, name, stop, lambda: None, self.lines.append)
        session.declare_subscriber("followspot/**", lambda sample: self.heard.append(str(sample.key_expr)))

    def ask(self, by: zenoh.Session, key: str) -> list[dict[str, object]]:
        """The answers to a request under this key."""
        return self.hear(by, key, envelope(Asked.of(key), {"run": "r"}))

    def hear(self, by: zenoh.Session, key: str, payload: bytes) -> list[dict[str, object]]:
        """The answers to these bytes as a request under this key."""
        handler = by.get(key, payload=payload, timeout=60.0)
        replies: list[dict[str, object]] = []
        while True:
            self.answers.answer()
            try:
                while (reply := handler.try_recv()) is not None:
                    if reply.ok is not None:
                        replies.append(json.loads(reply.ok.payload.to_bytes()))
            except zenoh.ZError:  # all replies are here
                break
            time.sleep(0.03)
        return replies
