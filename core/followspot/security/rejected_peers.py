"""Peers that Zenoh does not let in: what its log says of them, counted.

Zenoh tells of them on standard output and nowhere else, so that passes through here while the door is open.
"""

from __future__ import annotations

import fcntl
import os
import re
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Self

from followspot.security.rejections import Rejections
from followspot.transport.zenoh.session import log_refusals

_STYLE = re.compile(rb"\x1b\[[0-9;]*m")
_TLS = re.compile(rb"zenoh_link_tls\S*: (?P<why>.*?)(?: Hint: .*)?$")
"""The hint is about something else."""
_UNLISTED = re.compile(rb"access_control: (?P<who>[0-9a-f]+) did not match any configured ACL subject")
_STDOUT = 1
_LONGEST = 1 << 16
"""Bytes of a line; what is longer comes in pieces."""
_ROOM = 1 << 20
"""Bytes that wait while this process hangs; workers write here, too, and go on meanwhile."""


class RejectedPeers:
    """Counts whom Zenoh refuses in this process, from a thread of its own; other output goes on its way."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        """tell: gets a line for each refusal. Open it before the first session."""
        self.rejections = Rejections(tell)
        self._out = os.dup(_STDOUT)
        reading, writing = os.pipe()
        fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, _ROOM)
        os.dup2(writing, _STDOUT)
        os.close(writing)
        self._thread = threading.Thread(target=self._listen, args=(reading,), name="door", daemon=True)
        self._thread.start()
        log_refusals()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Standard output is as it was; what was said is counted, and the counts are logged."""
        os.dup2(self._out, _STDOUT)
        self._thread.join(timeout=1.0)  # a worker that is still there has the pipe, too
        self.rejections.sum_up("peers")

    def _listen(self, reading: int) -> None:
        with os.fdopen(reading, "rb") as said, os.fdopen(self._out, "wb", buffering=0) as out:
            while line := said.readline(_LONGEST):
                if not self._refused(_STYLE.sub(b"", line.rstrip())):
                    with suppress(OSError):  # nobody reads it: that must not stop who writes
                        out.write(line)

    def _refused(self, line: bytes) -> bool:
        """Count the line if it tells of a refusal; whether it does."""
        if found := _TLS.search(line):
            why = found["why"].decode(errors="replace")
            self.rejections.add("certificate" if "certificate" in why else "tls", "a peer", why.rstrip("."))
        elif found := _UNLISTED.search(line):
            why = "it has a certificate, but is not on the list of hosts; whatever it sends is ignored"
            self.rejections.add("unlisted", f"peer {found['who'].decode()}", why)
        return found is not None
