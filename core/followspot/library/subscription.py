"""Messages of ports, as they come, for a loop in a script or a notebook."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import AsyncIterator, Callable, Collection, Iterator
from typing import Self

from followspot.errors import FollowspotError
from followspot.messages import Message

CAPACITY = 64
"""Messages that wait for the loop."""
_STALLED = 1.0
"""Seconds without a message after which the reason is looked for."""


class Subscription:
    """Iterates over the messages of one or more ports until the run ends; leaving the loop ends nothing.

    A lossless one holds up the run while `CAPACITY` messages wait; any other keeps the newest, and `dropped`
    counts the rest. Iterate with ``for`` in a thread or with ``async for`` in an event loop.

    siblings: all subscriptions of the run: one that nobody has begun to read may hold up the others.
    """

    def __init__(
        self,
        port: str,
        *,
        lossless: bool,
        failure: Callable[[], Exception | None],
        siblings: Collection[Subscription] = (),
    ) -> None:
        """failure: what the run failed with, raised when the messages have been read."""
        self.port = port
        self.lossless = lossless
        self.dropped = 0
        self._failure = failure
        self._siblings = siblings
        self._begun = False
        self._messages: deque[Message] = deque()
        self._changed = threading.Condition()
        self._senders = 0
        self._ended = self._closed = False

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Message:
        self._begun = True
        with self._changed:
            while not (self._messages or self._ended or self._closed):
                if not self._changed.wait(_STALLED):
                    self.check_siblings()
            if self._messages and not self._closed:
                message = self._messages.popleft()
                self._changed.notify_all()
                return message
        error = None if self._closed else self._failure()
        if error is not None:
            raise error
        raise StopIteration

    def __aiter__(self) -> AsyncIterator[Message]:
        return self._asynchronous()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Read no more; the run goes on, and nothing waits for this subscription. Safe from any thread."""
        with self._changed:
            self._closed = True
            self._messages.clear()
            self._changed.notify_all()

    def put(self, message: Message) -> None:
        """A message of the run; waits while a lossless subscription is full."""
        with self._changed:
            while self.lossless and len(self._messages) >= CAPACITY and not self._closed:
                self._changed.wait()
            if self._closed:
                return
            if len(self._messages) >= CAPACITY:
                self._messages.popleft()
                self.dropped += 1
            self._messages.append(message)
            self._changed.notify_all()

    def join(self) -> None:
        """One more port sends here."""
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
        """The run is over, whoever else was to send."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    @property
    def _holds_up(self) -> bool:
        """Whether the run waits for somebody to begin to read."""
        return self.lossless and not (self._begun or self._closed) and len(self._messages) >= CAPACITY

    def check_siblings(self) -> None:
        """Raises FollowspotError if nothing comes because nobody reads another port."""
        for other in self._siblings:
            if other._holds_up:
                both = f', or subscribe to both at once: ports=["{self.port},{other.port}"]'
                raise FollowspotError(
                    f"nobody reads {other.port}, which holds up the run: read it in a thread of its own, "
                    f"close it{'' if other is self else both}"
                )

    async def _asynchronous(self) -> AsyncIterator[Message]:
        done = object()
        items: Iterator[Message | object] = iter(self)
        while (item := await asyncio.to_thread(next, items, done)) is not done:
            assert isinstance(item, Message)
            yield item
