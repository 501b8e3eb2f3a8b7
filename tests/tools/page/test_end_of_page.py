"""When a run has ended, every browser learns it, however late it reads."""

from __future__ import annotations

import socket
import threading
from contextlib import ExitStack, suppress
from pathlib import Path

import numpy as np
from tests.tools.page.page_socket import UPGRADE, things
from tests.tools.page.served import at, served, tracks
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from followspot.tracking import Frame
from followspot_dashboard.picture import picture_of

ENOUGH = 120
"""Pictures that no socket's buffers hold together."""


class Late:
    """A browser that reads nothing until it is told to, and all that it has read then."""

    def __init__(self, host: str) -> None:
        self.read = b""
        name, _, port = host.rpartition(":")
        self.socket = socket.socket()
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.connect((name, int(port)))
        self.socket.sendall(UPGRADE.format(host=host).replace("\n", "\r\n").encode())

    def read_after(self, other: ClientConnection) -> None:
        """Read when another browser was told of the end, or was cut off."""
        with suppress(ConnectionClosed):
            while (said := other.recv(timeout=60)) and '"end"' not in str(said):
                pass
        with self.socket:
            while b'"type": "end"' not in self.read and (came := self.socket.recv(1 << 16)):
                self.read += came


def test_a_browser_that_reads_late_is_told_that_the_run_has_ended(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype="u1")
    picture = picture_of(at(0, Frame("cam0", noise)), 320)  # type: ignore[arg-type]
    assert picture is not None
    with ExitStack() as browsers, served(tmp_path) as page:  # the page ends first
        late = Late(page.host)
        other = browsers.enter_context(page.look(max_size=None))
        next(things(other, "scene"))
        for number in range(ENOUGH):
            page.send("camera/cam0.out", at(number, picture))
            page.send("track.tracks", at(number, tracks(1)))
            while next(things(other, "view"))["seq"] != number:
                continue
        reading = threading.Thread(target=late.read_after, args=(other,))
        reading.start()
    reading.join(timeout=60)
    assert b'"type": "end"' in late.read, late.read[-300:]
