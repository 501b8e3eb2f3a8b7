"""The waiting of sources that keep a pace of their own."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable


class Pace:
    """Lets the sources of a worker wait until a message is due, but not beyond the end of the run."""

    def __init__(self) -> None:
        self._end = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._heard: dict[int, Callable[[], bool]] = {self._end: lambda: False}

    def __del__(self) -> None:
        os.close(self._end)

    def hear(self, fd: int, callback: Callable[[], bool]) -> None:
        """Call back when the descriptor is readable during :meth:`wait`, until it says that it is over."""
        self._heard[fd] = callback

    def wait(self, seconds: float) -> bool:
        """Wait so long; False, and at once, if the run is to end. For the worker's thread alone."""
        return self._wait(seconds, self._heard)

    def wait_aside(self, seconds: float) -> bool:
        """The same for other threads, which hear nothing else."""
        return self._wait(seconds, {self._end: self._heard[self._end]})

    def end(self) -> None:
        """Wait no more, now and from now on. Safe in signal handlers and threads."""
        os.eventfd_write(self._end, 1)

    def _wait(self, seconds: float, heard: dict[int, Callable[[], bool]]) -> bool:
        due = time.monotonic() + seconds
        while True:
            left = max(0.0, due - time.monotonic())
            poll = select.poll()
            for fd in heard:
                poll.register(fd, select.POLLIN)
            ready = [fd for fd, _ in poll.poll(int(left * 1000))]
            if self._end in ready:
                return False
            for fd in ready:
                if heard[fd]():
                    del heard[fd]
            if not ready:
                time.sleep(max(0.0, due - time.monotonic()))  # less than a millisecond
                return True
