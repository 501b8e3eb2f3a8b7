"""The memory of a host's ledger: it outlives the workers, and as a file also the agent."""

from __future__ import annotations

import os
import select
import signal
from contextlib import suppress
from pathlib import Path

_KILL_TIMEOUT_MS = 5000
"""Longest wait for the exit of a killed process, ms."""


def ledger_memory(file: Path | None, size: int) -> int:
    """A descriptor of `size` bytes of memory; of the file, with its contents, if a file is given.

    A hanging worker of a dead agent may still write to the file. It is killed, because each ledger word has
    one writer. Raises OSError if there is no space; all blocks are allocated at once.
    """
    if file is None:
        fd = os.memfd_create("followspot-ledger", os.MFD_CLOEXEC)
    else:
        fd = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
        _kill_users(file.resolve())
    try:
        os.ftruncate(fd, size)
        os.posix_fallocate(fd, 0, size)  # else the first write on a full disk would kill the writer by SIGBUS
    except OSError:
        os.close(fd)
        raise
    return fd


def _kill_users(file: Path) -> None:
    """Kill all other processes that have the file mapped, and wait until they have exited."""
    for maps in Path("/proc").glob("[0-9]*/maps"):
        if maps.parent.name != str(os.getpid()) and _maps_file(maps, file):
            with suppress(ProcessLookupError):
                _kill_user(maps, file)


def _maps_file(maps: Path, file: Path) -> bool:
    """True if a process has the file mapped; maps: its table in /proc, whose lines end with paths."""
    with suppress(OSError):  # it has ended, or belongs to another user
        return any(line.endswith(f" {file}\n") for line in maps.open(errors="replace"))
    return False


def _kill_user(maps: Path, file: Path) -> None:
    """Kill a process, if its id still belongs to one that maps the file. Raises ProcessLookupError."""
    process = os.pidfd_open(int(maps.parent.name))
    try:
        if _maps_file(maps, file):
            signal.pidfd_send_signal(process, signal.SIGKILL)
            exited = select.poll()
            exited.register(process, select.POLLIN)
            exited.poll(_KILL_TIMEOUT_MS)
    finally:
        os.close(process)
