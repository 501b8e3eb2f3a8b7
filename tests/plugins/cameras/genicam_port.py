"""The one port of GigE Vision, which cameras of several test processes must not use at once."""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import gettempdir


@contextmanager
def own_port() -> Iterator[None]:
    """Wait until no other test process has a camera on loopback."""
    with (Path(gettempdir()) / "followspot-port-3956.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
