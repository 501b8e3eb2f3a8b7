"""The sink behind subscriptions: it hands messages to the loops of the process that asked for them."""

from __future__ import annotations

from collections.abc import Sequence

from followspot.library.subscription import Subscription
from followspot.messages import Message
from followspot.stage import Field, Stage, StageParams

_open: dict[str, Sequence[Subscription]] = {}
"""Subscriptions of this process by key."""


class SubscriptionSink(Stage):
    """Hand every message to subscriptions of a script; `followspot.run(ports=...)` adds it."""

    class Params(StageParams):
        """Which subscriptions."""

        key: str = Field(description="subscriptions of this process")

    params: Params

    def setup(self) -> None:
        """Find the subscriptions. Raises RuntimeError in any process but the one that has them."""
        if self.params.key not in _open:
            raise RuntimeError("the subscriptions are those of another process")
        self.subscriptions = _open[self.params.key]

    def process(self, message: Message) -> None:
        """Hand the message over; a lossless subscription that is full is waited for."""
        for subscription in self.subscriptions:
            subscription.put(message)

    def close(self) -> None:
        """A port has ended."""
        for subscription in getattr(self, "subscriptions", ()):
            subscription.leave()


def offer_subscriptions(key: str, subscriptions: Sequence[Subscription]) -> None:
    """Let the sink with this key hand its messages to these."""
    _open[key] = subscriptions


def withdraw_subscriptions(key: str) -> None:
    """The run is over."""
    _open.pop(key, None)
