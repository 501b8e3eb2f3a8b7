"""A file descriptor that any thread can make readable."""

from __future__ import annotations

import contextlib
import os
from threading import RLock


class WakeupEvent:
    """An eventfd that wakes a poll; setting it after it was closed does nothing."""

    def __init__(self) -> None:
        self._fd = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._lock = RLock()  # a signal handler may set it while its own thread closes it
        self._open = True

    def fileno(self) -> int:
        """File descriptor, readable while the event is set."""
        return self._fd

    def set(self) -> None:
        """Set the event. Safe in signal handlers and threads."""
        with self._lock:  # the descriptor may belong to something else once it is closed
            if self._open:
                os.eventfd_write(self._fd, 1)

    def clear(self) -> None:
        """Clear the event."""
        with contextlib.suppress(BlockingIOError):
            os.eventfd_read(self._fd)

    def close(self) -> None:
        """Close the descriptor."""
        with self._lock:
            if self._open:
                self._open = False
                os.close(self._fd)
