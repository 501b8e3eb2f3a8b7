"""Live cameras that vanish and come back: the base of their sources."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from functools import cached_property
from threading import Event
from typing import ClassVar, TypeVar

from followspot import Source, Stage
from followspot.tracking import Frame

FIRST_WAIT, LONGEST_WAIT = 0.2, 1.0
"""Pause before connecting again, s; it doubles with every failure."""
T = TypeVar("T")
READ_TIMEOUT = (
    "time without a picture after which the camera counts as gone and is opened again; raising it tolerates "
    "pauses, and notices a lost camera later"
)
"""Description of the parameter `read_timeout` of live cameras."""


class LiveCamera(Stage, ABC):
    """Base of live sources: a subclass names its camera and takes pictures from one connection to it."""

    live: ClassVar[bool] = True
    per_camera: ClassVar[bool] = True

    @property
    @abstractmethod
    def origin(self) -> str:
        """The camera as users know it, without secrets."""

    @abstractmethod
    def session(self) -> Iterator[Frame]:
        """Frames of one connection, until `stopped` is set. Raises ConnectionError if the camera is gone."""

    @cached_property
    def stopped(self) -> Event:
        """Ends the waiting when it is set."""
        return Event()

    def process(self) -> Source[Frame]:
        """Frames as they come; connects again when the camera is gone. Raises what `session` raises else."""
        yield from sessions(self.session, self.stopped, self.say)

    def say(self, text: str) -> None:
        """Tell the user about the camera."""
        self.context.warn(f"{self.origin}: {text}")

    def close(self) -> None:
        """End the waiting, also from another thread."""
        self.stopped.set()


def sessions(session: Callable[[], Iterator[T]], stopped: Event, say: Callable[[str], None]) -> Iterator[T]:
    """The items of one session after the other, with exponential back-off between, until `stopped` is set.

    A session whose device is gone raises ConnectionError. say: tells the user once that it is gone, and once
    when it is back, how long it was away, and how often it has been.
    """
    wait, since, times = FIRST_WAIT, 0.0, 0
    while not stopped.is_set():
        try:
            for item in session():
                if since:
                    times += 1
                    often = f"; it was away {times} times" if times > 1 else ""
                    say(f"is back after {time.monotonic() - since:.1f} s{often}")
                wait, since = FIRST_WAIT, 0.0
                yield item
        except ConnectionError as error:
            if not since and not stopped.is_set():
                say(f"{error}; connecting again until it answers")
            since = since or time.monotonic()
        stopped.wait(wait)
        wait = min(2 * wait, LONGEST_WAIT)
