"""The change that is under way in a run, and the things for which it waits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from threading import Lock

from followspot.errors import FollowspotError

GIVEN_UP = (FollowspotError, KeyboardInterrupt)
"""Exceptions for which a change that has begun is undone. Ctrl-C is one of them, because a command may lead
the change itself: it must not leave the run half changed."""
OnWait = Callable[[str], None]
"""Called with what a change waits for from now on, for example "host pc-left to build the new stages"."""


def no_notice(_: str) -> None:
    """The `OnWait` of a caller that does not show what the change waits for."""


def host_names(hosts: Iterable[str]) -> str:
    """Hosts in a sentence; "" is the operator's own."""
    return " and ".join(f"host {name}" if name else "this host" for name in hosts)


class ChangeUnderWay:
    """Lets the changes of a run wait for each other. Safe from any thread.

    waits_for: what the one under way waits for, "" if none is, or it waits for nothing.
    """

    def __init__(self) -> None:
        self.waits_for = ""
        self._lock = Lock()

    @contextmanager
    def alone(self) -> Iterator[None]:
        """The block is the only change under way."""
        with self._lock:
            try:
                yield
            finally:
                self.wait_for("")

    @property
    def under_way(self) -> bool:
        """Whether a change is under way."""
        return self._lock.locked()

    def wait_for(self, what: str) -> None:
        """Note what the change waits for; this is an `OnWait`."""
        self.waits_for = what
