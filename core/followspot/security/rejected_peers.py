"""Counts the peers that Zenoh rejects, from its log.

Zenoh logs rejected peers only to standard output, so a thread filters standard output of this process.
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
from followspot.transport.zenoh.session import log_rejections

_STYLE = re.compile(rb"\x1b\[[0-9;]*m")
_TLS = re.compile(rb"zenoh_link_tls\S*: (?P<why>.*?)(?: Hint: .*)?$")
"""Leaves out Zenoh's hint, which does not fit."""
_ALERTED = (
    "; it does not take the certificate of this host: are both of one authority, the clocks right, and the "
    "address one of the certificate?"
)
_UNLISTED = re.compile(rb"access_control: (?P<peer>[0-9a-f]+) did not match any configured ACL subject")
_STDOUT = 1
_MAX_LINE = 1 << 16
"""Longest line, bytes; a longer line is read in pieces."""
_PIPE_SIZE = 1 << 20
"""Size of the pipe, bytes; workers write to it, too, and must not block if this process hangs."""


class RejectedPeers:
    """Counts the peers that Zenoh rejects in this process; passes all other output on."""

    def __init__(self, log_line: Callable[[str], None]) -> None:
        """log_line: gets a line for each rejection. Make this before the first Zenoh session."""
        self.rejections = Rejections(log_line)
        self._out = os.dup(_STDOUT)
        reading, writing = os.pipe()
        fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, _PIPE_SIZE)
        os.dup2(writing, _STDOUT)
        os.close(writing)
        self._thread = threading.Thread(target=self._listen, args=(reading,), name="door", daemon=True)
        self._thread.start()
        log_rejections()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Restore standard output, count the remaining lines and log the counts."""
        os.dup2(self._out, _STDOUT)
        self._thread.join(timeout=1.0)  # a worker that is still alive keeps the pipe open
        self.rejections.sum_up("peers")

    def _listen(self, reading: int) -> None:
        with os.fdopen(reading, "rb") as said, os.fdopen(self._out, "wb", buffering=0) as out:
            while line := said.readline(_MAX_LINE):
                if not self._refused(_STYLE.sub(b"", line.rstrip())):
                    with suppress(OSError):  # a closed standard output must not stop the process
                        out.write(line)

    def _refused(self, line: bytes) -> bool:
        """Count the line if it reports a rejection; return whether it does."""
        if found := _TLS.search(line):
            why = found["why"].decode(errors="replace")
            reason = "certificate" if "certificate" in why else "tls"
            self.rejections.add(reason, "a peer", why.rstrip(".") + _ALERTED * ("received fatal" in why))
        elif found := _UNLISTED.search(line):
            why = "it has a certificate, but is not on the list of hosts; whatever it sends is ignored"
            self.rejections.add("unlisted", f"peer {found['peer'].decode()}", why)
        return found is not None
