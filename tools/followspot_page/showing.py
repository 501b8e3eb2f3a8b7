"""A run's end of the page: starts its process, tells it how the run is, and ends it."""

from __future__ import annotations

import json
import os
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import NamedTuple

from followspot.deploy.status import OnStatus, RunStatus
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.graph.ship import plan_to_data
from followspot_page.picture_of_run import status_to_data

ORDER, STATUS = "order.json", "status"


class Address(NamedTuple):
    """Where the page is served; port: 0 for any; firm: whether another will not do where it is taken."""

    host: str
    port: int
    firm: bool


@cache
def folder() -> Path:
    """The private folder of this process's page, where taps find it; made when the page is shown."""
    return Path(tempfile.gettempdir()) / f"followspot-page-{os.getpid()}-{secrets.token_hex(4)}"


@contextmanager
def shown(plan: Plan, at: Address) -> Iterator[tuple[str, OnStatus]]:
    """The page of a run: its address, and what is to be called with the run's status.

    Raises FollowspotError where the page cannot be served there.
    """
    place = folder()
    place.mkdir(mode=0o700)
    try:
        order = {"plan": plan_to_data(plan), **at._asdict()}
        (place / ORDER).write_text(json.dumps(order))
        with _process(place) as process, socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as line:
            port = _port(process, at)
            line.setblocking(False)
            line.connect(str(place / STATUS))
            host = f"[{at.host}]" if ":" in at.host else at.host

            def tell(status: RunStatus) -> None:
                try:
                    line.send(status_to_data(status))
                except OSError:
                    return  # the page is busy or gone; the run is not

            yield f"http://{host}:{port}/", tell
    finally:
        shutil.rmtree(place, ignore_errors=True)


@contextmanager
def _process(place: Path) -> Iterator[subprocess.Popen[str]]:
    """The page's process; it ends when its input does, and is killed where it does not."""
    process = subprocess.Popen(
        [sys.executable, "-m", "followspot_page.server", str(place)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C ends the run, and the run its page
    )
    try:
        yield process
    finally:
        assert process.stdin is not None
        process.stdin.close()
        try:
            process.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _port(process: subprocess.Popen[str], at: Address) -> int:
    """The port that the page listens on. Raises FollowspotError where there is none."""
    assert process.stdout is not None
    line = process.stdout.readline().strip()
    if line.isdigit():
        return int(line)
    why = line.removeprefix("error ") or f"its process ended with code {process.wait()}"
    raise FollowspotError(
        f"the page cannot be served on {at.host}:{at.port}: {why}; name another with --dashboard-at"
    )
