"""The stage behind subscriptions: it hands messages to the loops of the process that asked for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from followspot.library.subscription import Subscription
from followspot.messages import Message
from followspot.stage_params import Field
from followspot.taps.port_tap import PortTap

SINK = "followspot.subscription"

_open: dict[str, Sequence[Subscription[Any]]] = {}
"""Subscriptions of this process by key."""


class SubscriptionSink(PortTap):
    """Hand every message to subscriptions of a script.

    With a key it is a sink that `followspot.run(ports=...)` adds to the graph, and it gets every message.
    Without a key it is a tap that is added to a port of a run that has begun; it drops messages that the
    script does not take in time.
    """

    class Params(PortTap.Params):
        key: str = Field("", description="subscriptions of this process")

    params: Params
    subscriptions: Sequence[Subscription[Any]] = ()

    def setup(self) -> None:
        """Find the subscriptions. Raises RuntimeError if the key belongs to another process."""
        key = self.params.key
        if not key:
            super().setup()
        elif key in _open:
            self.subscriptions = _open[key]
        else:
            raise RuntimeError("the subscriptions are those of another process")

    def process(self, message: Message) -> None:
        """Hand the message over; wait if a lossless subscription is full. Raises EOFError; see `PortTap`."""
        if not self.params.key:
            super().process(message)
        for subscription in self.subscriptions:
            subscription.put(message)

    def close(self) -> None:
        """Tell the subscriptions that the port has ended."""
        for subscription in self.subscriptions:
            subscription.leave()
        super().close()


def offer_subscriptions(key: str, subscriptions: Sequence[Subscription[Any]]) -> None:
    """Let the sink with this key hand its messages to these subscriptions."""
    _open[key] = subscriptions


def withdraw_subscriptions(key: str) -> None:
    """Forget the subscriptions of this key at the end of the run."""
    _open.pop(key, None)
