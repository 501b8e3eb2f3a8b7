"""Memory that two processes share; it has no name in the filesystem, so none is left behind."""

from __future__ import annotations

import fcntl
import mmap
import os

_SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL


class Memory:
    """A mapped memory file, which the system frees when the last process unmaps it.

    Its size is sealed: a peer that could shrink it could crash every process that maps it.
    """

    def __init__(self, fd: int, size: int, *, writable: bool) -> None:
        """Map `fd`, and own it from now on.

        Raises ValueError if it is not a sealed memory file of at least `size` bytes, OSError if it cannot be
        mapped.
        """
        self.fd = fd
        if not _sealed(fd) or os.fstat(fd).st_size < size:
            raise ValueError(f"not a sealed memory file of {size} bytes")
        access = mmap.PROT_READ | mmap.PROT_WRITE if writable else mmap.PROT_READ
        self.bytes = mmap.mmap(fd, size, mmap.MAP_SHARED, access)

    @classmethod
    def create(cls, name: str, size: int) -> Memory:
        """Zeroed memory of `size` bytes, of which only touched pages exist. Raises OSError."""
        fd = os.memfd_create(name, os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(fd, size)
            fcntl.fcntl(fd, fcntl.F_ADD_SEALS, _SEALS)
        except OSError:
            os.close(fd)
            raise
        return cls(fd, size, writable=True)

    def __del__(self) -> None:
        os.close(self.fd)


def _sealed(fd: int) -> bool:
    """Whether it is a memory file that no process can shrink."""
    try:
        return bool(fcntl.fcntl(fd, fcntl.F_GET_SEALS) & fcntl.F_SEAL_SHRINK)
    except OSError:  # not a memory file
        return False
