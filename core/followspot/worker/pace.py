"""Interruptible waiting for sources that keep a pace of their own."""

from __future__ import annotations

import select
import time
from collections.abc import Callable

from followspot.transport.wakeup_event import WakeupEvent


class Pace:
    """Lets the sources of a worker wait until a message is due; the end of the run ends the wait."""

    def __init__(self) -> None:
        self._end = WakeupEvent()
        self._watched: dict[int, Callable[[], bool]] = {}

    def __del__(self) -> None:
        self._end.close()

    def watch(self, fd: int, callback: Callable[[], bool]) -> None:
        """Call back when the descriptor is readable during :meth:`wait`, until the callback returns True."""
        self._watched[fd] = callback

    def wait(self, seconds: float) -> bool:
        """Wait so long; returns False at once when the run is to end. For the worker's thread alone."""
        return self._wait(seconds, self._watched)

    def wait_in_thread(self, seconds: float) -> bool:
        """Wait like :meth:`wait`, in another thread: no callback is called."""
        return self._wait(seconds, {})

    def end(self) -> None:
        """End every wait, now and from now on. Safe in signal handlers and threads."""
        self._end.set()

    def _wait(self, seconds: float, watched: dict[int, Callable[[], bool]]) -> bool:
        """See `wait`; `watched`: what to call when a descriptor is readable."""
        due = time.monotonic() + seconds
        while True:
            left = max(0.0, due - time.monotonic())
            poll = select.poll()
            for fd in (self._end.fileno(), *watched):
                poll.register(fd, select.POLLIN)
            ready = [fd for fd, _ in poll.poll(int(left * 1000))]
            if self._end.fileno() in ready:
                return False
            for fd in ready:
                if watched[fd]():
                    del watched[fd]
            if not ready:
                time.sleep(max(0.0, due - time.monotonic()))  # less than a millisecond
                return True
