"""What both ends of an edge over Zenoh agree on (docs/wire.md)."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable
from struct import Struct
from typing import Any

import zenoh
from zenoh.handlers import Callback

NUMBER = Struct("<QQ")
"""Attachment: number of the token, and of messages up to and with it."""
CREDIT = Struct("<QQ")
"""What a reader reports: messages consumed, tokens taken."""
WINDOW = 256
"""Most tokens under way: as many settled times do not fill any buffer, so that a put does not block."""


def publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    """A publisher that drops nothing and waits for no batch."""
    return session.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK, express=True)


def reached(by: zenoh.Publisher) -> bool:
    """Whether anybody gets what is put."""
    return by.matching_status.matching  # type: ignore[attr-defined,no-any-return]  # the stub calls it a bool


def presence(session: zenoh.Session, key: str, callback: Callable[[zenoh.Sample], None]) -> Any:
    """Watch the liveliness tokens of the other side, those that are there already included."""
    return session.liveliness().declare_subscriber(key, Callback(callback, indirect=False), history=True)


def undeclare(entities: Iterable[Any]) -> None:
    """Undeclare publishers, subscribers and tokens, in order, also where the session was closed first."""
    for entity in entities:
        with contextlib.suppress(zenoh.ZError):
            entity.undeclare()


def chunks(sample: zenoh.Sample) -> list[str]:
    """The sample's key: what goes before, and its last two chunks."""
    return str(sample.key_expr).rsplit("/", 2)
