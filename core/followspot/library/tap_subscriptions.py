"""Subscriptions to a run that has begun: taps at its ports send to this process, from every host."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

from followspot.errors import FollowspotError
from followspot.graph.output_ports import chosen_ports, output_ports
from followspot.library.run_taps import RunTaps
from followspot.library.sink import SINK
from followspot.library.subscription import Subscription
from followspot.messages import InvalidMessage, Message
from followspot.operator.run_handle import RunHandle
from followspot.taps.framing import Record
from followspot.taps.receivers import Gaps
from followspot.wire import unpack

_PERIOD = 1.0
"""Seconds between two checks whether the run has ended, or has moved a tapped stage to another host."""
_LEAVING = 3.0
"""Seconds for the last messages of a run to arrive."""

Failure = Callable[[], Exception | None]
"""Why the run failed; None if it did not."""


class TapSubscriptions:
    """The subscriptions of one handle, by name."""

    def __init__(self, run: RunHandle, failure: Failure = lambda: None) -> None:
        self._run = run
        self._failure = failure
        self._feeds: dict[str, _Feed] = {}
        self._lock = threading.Lock()

    def subscription(self, word: str) -> Subscription[Any]:
        """The open subscription of this name, or a new one. Raises FollowspotError; see `_Feed`."""
        with self._lock:
            feed = self._feeds.get(word)
            if feed is None or feed.subscription.closed:
                feed = self._feeds[word] = _Feed(self._run, word, self._failure)
            return feed.subscription

    def end(self) -> None:
        """The run has ended: the loops end after the last messages."""
        for feed in tuple(self._feeds.values()):
            feed.end()

    def close(self) -> None:
        """Remove every tap."""
        for feed in tuple(self._feeds.values()):
            feed.subscription.close()


class _Feed:
    """Taps at ports, and the subscription that they feed. Closing the subscription removes them."""

    def __init__(self, run: RunHandle, word: str, failure: Failure) -> None:
        """Raises InputError if there is no such port, FollowspotError if it cannot be reached from here."""
        self._run = run
        plan = run.plan()
        ports = output_ports(plan)
        self._types = {name: ports[name] for name in chosen_ports(word, ports, "ports", plan.offered)}
        self.subscription = Subscription[Any](
            word, self._types.values(), lossless=False, failure=failure, on_close=self._close
        )
        self._over = threading.Event()
        self._taps = RunTaps(run, self._types, SINK, self._consume)
        threading.Thread(target=self._watch, name=f"taps of {word}", daemon=True).start()

    def end(self) -> None:
        """Take the last messages, and end the loop."""
        if self._close(_LEAVING):
            self.subscription.end()

    def _watch(self) -> None:
        while not self._over.wait(_PERIOD):
            if self._run.over():
                self.end()
                return
            with suppress(FollowspotError):
                self._taps.follow()

    def _consume(self, records: Iterator[Record]) -> None:
        """Pass on the messages of one sender; count malformed messages, end at a malformed stream."""
        gaps = Gaps()
        with suppress(ValueError, KeyError):
            for port, number, packed in records:
                missing = gaps.before(port, number)
                try:
                    message = unpack(packed, self._types[port])
                except InvalidMessage:
                    self.subscription.dropped += missing + 1
                    continue
                if isinstance(message, Message):
                    self.subscription.put(message, missing)

    def _close(self, timeout: float = 0.0) -> bool:
        """Remove the taps; False if that was done before."""
        self._over.set()
        return self._taps.close(timeout)
