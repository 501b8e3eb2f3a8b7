"""The change that a run makes at the moment, and what it waits for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from threading import Lock

from followspot.errors import FollowspotError

GIVEN_UP = (FollowspotError, KeyboardInterrupt)
"""What a change is undone for, half-way: where a command leads it, Ctrl-C must not leave the run so."""
OnWait = Callable[[str], None]
"""Called with what a change waits for from now on, for example "host pc-left to build the new stages"."""


def nobody(_: str) -> None:
    """An `OnWait` if nobody asks."""


def named(hosts: Iterable[str]) -> str:
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

    def wait_for(self, what: str) -> None:
        """Keep what the change waits for: an `OnWait`."""
        self.waits_for = what
