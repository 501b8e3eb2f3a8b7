"""The system calls that V4L2 needs, behind an interface that tests replace."""

from __future__ import annotations

import fcntl
import mmap
import os
import select
from ctypes import Structure
from typing import Protocol

import numpy as np

from followspot.messages import Array


class Kernel(Protocol):
    """The system calls. Every method raises OSError as the kernel does."""

    def open(self, path: str) -> int:
        """The file of a device; its requests do not wait."""

    def ioctl(self, file: int, request: int, argument: Structure) -> None:
        """Carry out a request; the answer is in the argument."""

    def map(self, file: int, length: int, offset: int) -> Array:
        """(length,) uint8: memory of the driver."""

    def wait(self, file: int, timeout: float) -> bool:
        """Whether the device has a picture or an event within `timeout`, s."""

    def close(self, file: int) -> None:
        """Release the device."""


class Linux:
    """The kernel of this host."""

    def open(self, path: str) -> int:
        """The file of a device; its requests do not wait."""
        return os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)

    def ioctl(self, file: int, request: int, argument: Structure) -> None:
        """Carry out a request; the answer is in the argument."""
        fcntl.ioctl(file, request, argument, True)

    def map(self, file: int, length: int, offset: int) -> Array:
        """(length,) uint8: memory of the driver, which is released with the array."""
        return np.frombuffer(mmap.mmap(file, length, offset=offset), "u1")

    def wait(self, file: int, timeout: float) -> bool:
        """Whether the device has something to tell within `timeout`, s: a picture, or that it is gone."""
        poll = select.poll()
        poll.register(file, select.POLLIN)
        return bool(poll.poll(round(timeout * 1000)))

    def close(self, file: int) -> None:
        """Release the device."""
        os.close(file)
