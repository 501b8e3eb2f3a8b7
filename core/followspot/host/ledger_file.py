"""The memory of a host's ledger: it outlives every worker, and as a file also the agent that counts in it."""

from __future__ import annotations

import os
import select
import signal
from contextlib import suppress
from pathlib import Path

_PATIENCE_MS = 5000
"""How long a process may take to be gone after it was killed, ms."""


def ledger_memory(file: Path | None, size: int) -> int:
    """A descriptor of `size` bytes of memory, of a file where one is given: what it holds stays.

    A worker of an agent that was killed may hang and still count in the file: it is killed, for each word has
    one writer. Raises OSError where there is no room, also on a disk that would only be full later.
    """
    if file is None:
        fd = os.memfd_create("followspot-ledger", os.MFD_CLOEXEC)
    else:
        fd = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
        _end_all(file.resolve())
    try:
        os.ftruncate(fd, size)
        os.posix_fallocate(fd, 0, size)  # else a full disk kills whoever counts for the first time
    except OSError:
        os.close(fd)
        raise
    return fd


def _end_all(file: Path) -> None:
    """Kill all processes that have the file in their memory, and wait until they are gone."""
    for maps in Path("/proc").glob("[0-9]*/maps"):
        if maps.parent.name != str(os.getpid()) and _has(maps, file):
            with suppress(ProcessLookupError):
                _end(maps, file)


def _has(maps: Path, file: Path) -> bool:
    """Whether a process has a file in its memory; maps: the table of it, a line ends with the path."""
    with suppress(OSError):  # it has ended, or is another user's
        return any(line.endswith(f" {file}\n") for line in maps.open(errors="replace"))
    return False


def _end(maps: Path, file: Path) -> None:
    """Kill a process, if its number still is that of the one that has the file. Raises ProcessLookupError."""
    process = os.pidfd_open(int(maps.parent.name))
    try:
        if _has(maps, file):
            signal.pidfd_send_signal(process, signal.SIGKILL)
            gone = select.poll()
            gone.register(process, select.POLLIN)
            gone.poll(_PATIENCE_MS)
    finally:
        os.close(process)
