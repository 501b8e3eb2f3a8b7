"""Starts and ends the page's process for a run of this machine."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass

from followspot import Network
from followspot.errors import FollowspotError
from followspot.operating_system.child_processes import module_command


@dataclass(frozen=True)
class PageOrder:
    """The page to start: the operator's process of its run, and the address.

    port: 0 for any; firm: no other port may replace a taken one; rate: pictures per second; run: its name, if
    it is under agents and has no operator here, which network leads to; plugin_files: with stages that agents
    have loaded; recording: the file to show instead of a run, "" for none.
    """

    pid: int
    host: str = "127.0.0.1"
    port: int = 0
    firm: bool = True
    rate: float = 10.0
    run: str = ""
    network: Network | None = None
    plugin_files: tuple[str, ...] = ()
    recording: str = ""


OVER = "."
"""The line that tells the page's process that the run has ended."""
FAREWELL = 8.0
"""Seconds that browsers have to read that the run has ended; each closes its socket when it has."""


class ShownPage:
    """A running page. url: its address; pid: of its process."""

    def __init__(self, process: subprocess.Popen[str], url: str) -> None:
        self._process = process
        self.url = url
        self.pid = process.pid

    def wait(self) -> int:
        """Block until the page ends with its run; its exit code."""
        return self._process.wait()


def address(host: str, port: int) -> str:
    """The page's address in a browser."""
    return f"http://{f'[{host}]' if ':' in host else host}:{port}/"


@contextmanager
def shown(order: PageOrder) -> Iterator[ShownPage]:
    """The page while the block runs. Raises FollowspotError if it cannot be served."""
    process = subprocess.Popen(
        module_command("followspot_page.server", json.dumps(asdict(order))),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C ends the run, and the run ends its page
    )
    try:
        yield ShownPage(process, address(order.host, _port(process, order)))
        if process.stdin is not None and process.poll() is None:
            process.stdin.write(OVER)  # the page reports a run that died if this line does not arrive
    finally:
        assert process.stdin is not None
        with suppress(BrokenPipeError):
            process.stdin.close()
        try:
            process.wait(timeout=FAREWELL + 10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _port(process: subprocess.Popen[str], order: PageOrder) -> int:
    """The port of the page. Raises FollowspotError if the page does not start."""
    assert process.stdout is not None
    line = process.stdout.readline().strip()
    if line.isdigit():
        return int(line)
    why = line.removeprefix("error ") or f"its process ended with code {process.wait()}"
    raise FollowspotError(f"the page cannot be served on {order.host}:{order.port}: {why}")
