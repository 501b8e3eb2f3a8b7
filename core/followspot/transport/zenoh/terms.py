"""Layouts, limits and keys that both ends of an edge over Zenoh share (docs/wire.md)."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterable
from struct import Struct
from typing import Any

import zenoh
from zenoh.handlers import Callback

from followspot.graph.plan import EdgeCodec
from followspot.transport.token import MAX_COUNT, MAX_WATERMARK, UNKNOWN

NUMBER = Struct("<QQQ")
"""Attachment: the writer's incarnation, number of the token, and of messages up to and with it."""
KNOWN = Struct("<q")
"""Behind `NUMBER` in the attachment: the watermark after a message, ns, if it is known already."""
CREDIT = Struct("<QQQQ")
"""A reader's report: incarnations of its writer and of its own, messages consumed, tokens taken."""
START = Struct("<QQQQ")
"""The start of a reader: incarnation of the writer, tokens and messages before, messages given to it."""
WINDOW = 256
"""Most tokens under way: so many watermarks fill no buffer, so that a put does not block."""
_INCARNATION = re.compile(r"[0-9]{1,9}", re.ASCII)


def numbers(layout: Struct, data: zenoh.ZBytes | None) -> tuple[int, ...] | None:
    """The numbers of a control token; None if it has another size, or a number out of range."""
    if data is None or len(data) != layout.size:
        return None
    found = layout.unpack(data.to_bytes())
    return found if max(found) <= MAX_COUNT else None


def attached(data: zenoh.ZBytes | None) -> tuple[tuple[int, ...], int] | None:
    """The numbers of a token and the watermark after it, `UNKNOWN` if it brings none; None if malformed."""
    if data is None or len(data) != NUMBER.size + KNOWN.size:
        found = numbers(NUMBER, data)
        return None if found is None else (found, UNKNOWN)
    packed = data.to_bytes()
    found, (watermark,) = NUMBER.unpack_from(packed), KNOWN.unpack_from(packed, NUMBER.size)
    return (found, watermark) if max(found) <= MAX_COUNT and abs(watermark) <= MAX_WATERMARK else None


def publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    """A publisher that drops no sample and does not batch."""
    return session.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK, express=True)


def has_subscriber(by: zenoh.Publisher) -> bool:
    """Whether the publisher has a subscriber."""
    return by.matching_status.matching  # type: ignore[attr-defined,no-any-return]  # the stub calls it a bool


def presence(session: zenoh.Session, key: str, callback: Callable[[zenoh.Sample], None]) -> Any:
    """Watch the liveliness tokens of the other side, including those that are there already."""
    return session.liveliness().declare_subscriber(key, Callback(callback, indirect=False), history=True)


def undeclare(entities: Iterable[Any]) -> None:
    """Undeclare publishers, subscribers and tokens, in order, even if the session is closed."""
    for entity in entities:
        with contextlib.suppress(zenoh.ZError):
            entity.undeclare()


def chunks(sample: zenoh.Sample, count: int) -> list[str]:
    """The last chunks of the sample's key, "" for those that it lacks: any peer may put on ``**``."""
    found = str(sample.key_expr).split("/")[-count:]
    return [""] * (count - len(found)) + found


def is_incarnation(chunk: str) -> bool:
    """Whether the chunk of a key is an incarnation."""
    return _INCARNATION.fullmatch(chunk) is not None


def codec_key(key: str, codec: EdgeCodec) -> str:
    """The key of an output port's tokens; edges with a codec other than raw have their own."""
    return key if codec == "raw" else f"{key}/{codec}"
