"""The runs in reach, each with the address of its page, and pages for those that have none.

A page holds a socket with an abstract name, which says its run and its address; the kernel removes it when
the page's process dies.
"""

from __future__ import annotations

import json
import os
import socket
import struct
import subprocess
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from followspot import Network
from followspot.errors import FollowspotError
from followspot.library.attach import runs_under
from followspot.library.handle import runs_here
from followspot.operating_system.child_processes import module_command
from followspot_page.page_process import PageOrder
from followspot_watch.runs import Listed, listed_here, listed_there

_SOCKETS = Path("/proc/net/unix")
_NAME_LENGTH = 16
"""Letters of a run's name in the name of a socket."""
_TIMEOUT = 1.0
"""Seconds that a page has to accept a connection."""
_BEGIN = 20.0
"""Seconds that a page has to find its run."""
_POLL_INTERVAL = 0.1
_PEER = struct.Struct("3i")
"""Process, user and group of a peer, as SO_PEERCRED gives them."""


def announced(run: str, url: str) -> socket.socket:
    """Tell other pages where the page of a run is, until the socket closes. Raises OSError."""
    found = socket.socket(socket.AF_UNIX)
    try:
        found.bind(f"\0{_prefix()}{os.getpid()}-{run[:_NAME_LENGTH]}-{url}")
        found.listen()
    except OSError:
        found.close()
        raise
    return found


def pages() -> dict[str, str]:
    """The address of the page of each run of this user on this machine, by the beginning of its name."""
    try:
        words = {line.rpartition(" @")[2] for line in _SOCKETS.read_text(errors="replace").splitlines()}
    except OSError:
        return {}
    found = {}
    for name in sorted(word for word in words if word.startswith(_prefix()) and _is_own(word)):
        _, run, url = name.removeprefix(_prefix()).split("-", 2)
        found[run] = url
    return found


class RunList:
    """The runs in reach, as a page lists them. order: of this page; run: the one that it shows."""

    def __init__(self, order: PageOrder, run: str) -> None:
        self._order = order
        self._run = run

    def data(self) -> list[dict[str, Any]]:
        """The runs for the browser; `page` is the address of a run's page, "" without one."""
        known = pages()
        return [
            {**asdict(one), "page": known.get(one.run[:_NAME_LENGTH], ""), "shown": one.run == self._run}
            for one in self._listed()
        ]

    def open(self, run: str) -> str:
        """The address of a run's page, which is begun if it has none. Raises FollowspotError."""
        one = next((one for one in self._listed() if one.run == run), None)
        if one is None:
            raise FollowspotError(f"there is no run {run[:8]} any more")
        if address := pages().get(run[:_NAME_LENGTH]):
            return address
        order = replace(self._order, port=0, run="" if one.process else run, pid=one.process or 0)
        process = subprocess.Popen(
            module_command("followspot_page.opened", json.dumps(asdict(order))),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        assert process.stdout is not None
        with process.stdout as said:
            line = said.readline().strip()
        if not line.startswith("http"):
            raise FollowspotError(line or "the page does not begin")
        deadline = time.monotonic() + _BEGIN
        while run[:_NAME_LENGTH] not in pages() and time.monotonic() < deadline:
            time.sleep(_POLL_INTERVAL)  # it announces itself once it has found its run
        return line

    def _listed(self) -> Iterator[Listed]:
        here = [listed_here(run) for run in runs_here()]
        yield from here
        known = {run.run for run in here}
        with suppress(FollowspotError):  # no agent is in reach
            for run in runs_under(self._network) if self._network is not None else ():
                if run.run not in known and not run.over:
                    yield listed_there(run)

    @property
    def _network(self) -> Network | None:
        network = self._order.network
        return network if network is not None and network.leads_somewhere else None


def _is_own(name: str) -> bool:
    """Whether a process of this user listens at the socket of this name."""
    with suppress(OSError), socket.socket(socket.AF_UNIX) as ours:
        ours.settimeout(_TIMEOUT)
        ours.connect(f"\0{name}")
        _, user, _ = _PEER.unpack(ours.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _PEER.size))
        return bool(user == os.getuid())
    return False


def _prefix() -> str:
    return f"followspot-page-{os.getuid()}-"
