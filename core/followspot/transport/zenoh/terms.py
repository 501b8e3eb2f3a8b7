"""What both ends of an edge over Zenoh agree on (docs/wire.md)."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterable
from struct import Struct
from typing import Any

import zenoh
from zenoh.handlers import Callback

from followspot.graph.plan import EdgeCodec
from followspot.transport.token import MAX_COUNT

NUMBER = Struct("<QQQ")
"""Attachment: the writer's incarnation, number of the token, and of messages up to and with it."""
CREDIT = Struct("<QQQQ")
"""What a reader reports: incarnations of its writer and of its own, messages consumed, tokens taken."""
START = Struct("<QQQQ")
"""Where a reader joins: incarnation of the writer, tokens and messages before, those given to it."""
WINDOW = 256
"""Most tokens under way: as many watermarks do not fill any buffer, so that a put does not block."""
_INCARNATION = re.compile(r"[0-9]{1,9}", re.ASCII)


def numbers(layout: Struct, data: zenoh.ZBytes | None) -> tuple[int, ...] | None:
    """The numbers of a control token; None where it has another size, or a number out of range."""
    if data is None or len(data) != layout.size:
        return None
    found = layout.unpack(data.to_bytes())
    return found if max(found) <= MAX_COUNT else None


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


def chunks(sample: zenoh.Sample, count: int) -> list[str]:
    """The last chunks of the sample's key, "" for those that it lacks: strangers may put on ``**``."""
    found = str(sample.key_expr).split("/")[-count:]
    return [""] * (count - len(found)) + found


def is_incarnation(chunk: str) -> bool:
    """Whether this is how an incarnation stands in the key of a liveliness token."""
    return _INCARNATION.fullmatch(chunk) is not None


def codec_key(key: str, codec: EdgeCodec) -> str:
    """The key of an output port's tokens: edges of another codec have one of their own."""
    return key if codec == "raw" else f"{key}/{codec}"
