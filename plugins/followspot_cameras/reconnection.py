"""Sessions with a device that vanishes and comes back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from threading import Event
from typing import TypeVar

FIRST_WAIT, LONGEST_WAIT = 0.2, 1.0
"""Pause before connecting again, s; it doubles with every failure."""
T = TypeVar("T")


def sessions(
    session: Callable[[], Iterator[T]],
    lost: type[Exception],
    stopped: Event,
    say: Callable[[str], None],
) -> Iterator[T]:
    """What one session after the other gives, with exponential back-off between them, until `stopped` is set.

    lost: raised by a session whose device is gone; say: tells the user once that it is, and once when it is
    back.
    """
    wait, gone = FIRST_WAIT, False
    while not stopped.is_set():
        try:
            for item in session():
                if gone:
                    say("is back")
                wait, gone = FIRST_WAIT, False
                yield item
        except lost as error:
            if not gone and not stopped.is_set():
                say(f"{error}; connecting again until it answers")
            gone = True
        stopped.wait(wait)
        wait = min(2 * wait, LONGEST_WAIT)
