"""Messages of ports, as they come, for a loop in a script or a notebook."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import AsyncIterator, Callable, Collection, Iterator
from contextlib import contextmanager
from typing import Any, Generic, TypeVar

from followspot.closing import Closing
from followspot.errors import FollowspotError
from followspot.messages import Message

M = TypeVar("M", bound=Message)
CAPACITY = 64
"""Messages that wait for the loop."""
_STALLED = 1.0
"""Seconds without a message after which the subscription looks for the reason."""


class Subscription(Closing, Generic[M]):
    """Iterates over the messages of one or more ports until the run ends. Leaving the loop closes it.

    A lossless subscription holds up the run while `CAPACITY` messages wait, except while the run obeys a
    request of this process (`yielding`). Any other keeps the newest, and `dropped` counts the rest. Iterate
    with ``for`` in a thread or with ``async for`` in an event loop;
    ``next(subscription)`` takes one message and leaves the subscription open.
    """

    def __init__(
        self,
        port: str,
        types: Collection[type[Message]],
        *,
        lossless: bool,
        failure: Callable[[], Exception | None],
        siblings: Collection[Subscription[Any]] = (),
        on_close: Callable[[], object] = lambda: None,
    ) -> None:
        """port: its name; types: of its messages.

        failure: returns the error of the run, raised after the last message; siblings: all subscriptions of
        the run, because an unread one may hold up the others; on_close: called at each close.
        """
        self.port = port
        self.types = frozenset(types)
        self.lossless = lossless
        self.dropped = 0
        self._failure = failure
        self._siblings = siblings
        self._on_close = on_close
        self._begun = False
        self._messages: deque[M] = deque()
        self._changed = threading.Condition()
        self._senders = self._requests = 0
        self._ended = self._closed = False

    def __iter__(self) -> Iterator[M]:
        try:
            while (message := self._next()) is not None:
                yield message
        finally:
            self.close()

    def __next__(self) -> M:
        message = self._next()
        if message is None:
            raise StopIteration
        return message

    async def __aiter__(self) -> AsyncIterator[M]:
        try:
            while (message := await asyncio.to_thread(self._next)) is not None:
                yield message
        finally:
            self.close()

    def __repr__(self) -> str:
        state = "closed" if self._closed else "ended" if self._ended else "open"
        return (
            f"<subscription to {self.port}: {state}, {len(self._messages)} waiting, {self.dropped} dropped>"
        )

    @property
    def closed(self) -> bool:
        """True after `close` or the end of a loop."""
        return self._closed

    def close(self) -> None:
        """Read no more; the run goes on and does not wait for this subscription. Safe from any thread."""
        with self._changed:
            self._closed = True
            self._messages.clear()
            self._changed.notify_all()
        self._on_close()

    @contextmanager
    def yielding(self) -> Iterator[None]:
        """Hold nothing up meanwhile: the loop itself may wait for the run, and all messages are kept."""
        self._request(1)
        try:
            yield
        finally:
            self._request(-1)

    def put(self, message: M, missing: int = 0) -> None:
        """Add a message of the run; wait while a lossless subscription is full.

        missing: messages before it that did not come.
        """
        with self._changed:
            while self._is_full and self.lossless and not (self._closed or self._requests):
                self._changed.wait()
            if self._closed:
                return
            self.dropped += missing
            if self._is_full and not self.lossless:
                self._messages.popleft()
                self.dropped += 1
            self._messages.append(message)
            self._changed.notify_all()

    def join(self) -> None:
        """Count one more port that sends here."""
        with self._changed:
            self._senders += 1

    def leave(self) -> None:
        """A port has ended; with the last one the loop ends."""
        with self._changed:
            self._senders -= 1
            if self._senders <= 0:
                self._ended = True
            self._changed.notify_all()

    def end(self) -> None:
        """The run is over: the loop ends after the messages that wait."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    @property
    def _is_full(self) -> bool:
        return len(self._messages) >= CAPACITY

    @property
    def _holds_up(self) -> bool:
        """True if the run waits for the first read."""
        return self.lossless and not (self._begun or self._closed) and self._is_full

    def _request(self, change: int) -> None:
        """Count a request that begins (1) or ends (-1)."""
        with self._changed:
            self._requests += change
            self._changed.notify_all()

    def check_siblings(self) -> None:
        """Raises FollowspotError if the run is held up by a subscription that no loop reads."""
        for other in self._siblings:
            if other._holds_up:
                both = f', or subscribe to both at once: ports=["{self.port},{other.port}"]'
                raise FollowspotError(
                    f"no loop reads {other.port}, which holds up the run: read it in a thread of its own, "
                    f"close it{'' if other is self else both}"
                )

    def _next(self) -> M | None:
        """The next message; None at the end.

        Raises the error of the run after the last message, and FollowspotError if nothing can come any more.
        """
        if self._closed and not self._begun:
            raise FollowspotError(
                f"{self.port} was closed before its first message was read: loop over it within the block of "
                "the run"
            )
        self._begun = True
        with self._changed:
            while not (self._messages or self._ended or self._closed):
                if not self._changed.wait(_STALLED):
                    self.check_siblings()
            if self._messages:
                message = self._messages.popleft()
                self._changed.notify_all()
                return message
        error = None if self._closed else self._failure()
        if error is not None:
            raise error
        return None
