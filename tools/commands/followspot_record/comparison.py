"""Two recordings of one port, message by message."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import zip_longest

from followspot.errors import FollowspotError
from followspot.messages import InvalidMessage, Message
from followspot.wire import unpack
from followspot_recording.contract import ContractError, message_type
from followspot_recording.records import Channel, Recorded


@dataclass(frozen=True)
class Compared:
    """The result for a port. messages: how many are equal; difference: the first one, "" for none."""

    port: str
    messages: int
    difference: str = ""


def compare(
    port: str, channel: Channel, old: Iterable[Recorded], new: Iterable[Recorded], *, whole: bool
) -> Compared:
    """Byte for byte, up to the first difference. whole: whether both must be equally long."""
    same = 0
    for before, after in zip_longest(old, new):
        if before is None or after is None:
            what = f"message {(before or after).seq} {'is new' if before is None else 'is missing'}"
            return Compared(port, same, what if whole else "")
        if before.data != after.data:
            return Compared(port, same, f"message {before.seq}: {_difference(channel, before, after)}")
        same += 1
    return Compared(port, same)


def _difference(channel: Channel, before: Recorded, after: Recorded) -> str:
    """Which part of a message differs."""
    try:
        kind = message_type(channel.contract)
        a, b = unpack(bytes(before.data), kind), unpack(bytes(after.data), kind)
    except (InvalidMessage, ContractError) as error:
        return str(error)
    if not isinstance(a, Message) or not isinstance(b, Message):
        raise FollowspotError(f"{channel.topic} holds something that is no message")
    return ", ".join(_different(a, b)) or "encoding"


def _different(a: Message, b: Message) -> Iterator[str]:
    if a.header[:3] != b.header[:3]:
        yield f"header {a.header[:3]} is now {b.header[:3]}"
    for name, _ in a.scalars:
        if repr(getattr(a, name)) != repr(getattr(b, name)):
            yield f"{name} {getattr(a, name)!r} is now {getattr(b, name)!r}"
    for column in a.columns:
        old, new = getattr(a, column.name), getattr(b, column.name)
        if old.shape != new.shape:
            yield f"column {column.name} of {old.shape} is now of {new.shape}"
        elif old.tobytes() != new.tobytes():
            yield f"column {column.name}"
