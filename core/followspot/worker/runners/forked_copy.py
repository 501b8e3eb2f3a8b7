"""A stage's `setup` that forks and returns in both processes: an error of the stage.

The new process would go on as a second worker with the channel, the edges and the files of the first one.
A process that ends within `setup`, that stays there, or that becomes another program is no such copy.
"""

from __future__ import annotations

import os
import select

from followspot.errors import FollowspotError
from followspot.stage import Stage
from followspot.worker.process_end import end_process

_SETUP_WAIT = 0.2
"""Seconds that processes which `setup` forked have to return from it while the worker waits."""
_CLOSE_WAIT = 1.0
"""Seconds that they have at the end of the stage: it should have ended them."""


class ForkedCopyError(FollowspotError):
    """A copy of the worker returned from `setup`; it has ended."""

    def __init__(self) -> None:
        super().__init__(
            "its setup forked this process and returned in both: end the new process within setup, "
            "by os._exit, or start it with subprocess"
        )


class ForkedCopies:
    """The processes that a stage's `setup` forked, if there are any."""

    def __init__(self, reading: int) -> None:
        """reading: end of a pipe whose other end these processes have."""
        self._reading = reading

    def check(self, seconds: float = _CLOSE_WAIT) -> None:
        """Wait until all have ended or become other programs, at most so long.

        Raises ForkedCopyError as soon as one has returned from `setup`.
        """
        if self._reading < 0:
            return
        poll = select.poll()
        poll.register(self._reading, select.POLLIN)
        if not poll.poll(seconds * 1e3):
            return
        returned = os.read(self._reading, 1)
        self.forget()
        if returned:
            raise ForkedCopyError

    def forget(self) -> None:
        """Close the pipe."""
        if self._reading >= 0:
            os.close(self._reading)
            self._reading = -1


NO_COPIES = ForkedCopies(-1)


def set_up(stage: Stage) -> ForkedCopies:
    """Call `setup` of a stage; return only in the process that called this.

    Raises ForkedCopyError if a process that `setup` forked returned from it, and what `setup` raises.
    """
    process = os.getpid()
    reading, writing = os.pipe()
    copies = ForkedCopies(reading)
    try:
        try:
            stage.setup()
        finally:
            if os.getpid() != process:
                os.write(writing, b"!")
                end_process(1)
            os.close(writing)
        copies.check(_SETUP_WAIT)
    except BaseException:
        copies.forget()
        raise
    return copies
