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
    """The result for a port. messages: how many are equal; difference: the first one, "" for none;
    unrepeated: why none of its messages can be repeated, "" if some were; lacks: the capture time, ns, of the
    first message that is sent again and that the recording lacks after its last one, None if there is none.
    """

    port: str
    messages: int
    difference: str = ""
    unrepeated: str = ""
    lacks: int | None = None


class RunningComparison:
    """Compares the messages that a port sends again with the recorded ones, one by one.

    recorded: the messages in the order of their capture times; same: how many are equal; difference: the
    first one, "" for none.
    """

    def __init__(self, channel: Channel, recorded: Iterable[Recorded]) -> None:
        self.same = 0
        self.difference = ""
        self._channel = channel
        self._recorded = iter(recorded)
        self._next = next(self._recorded, None)
        self._low = 0 if self._next is None else self._next.time

    def begin(self, low: int) -> None:
        """Compare from this capture time on, ns; what was recorded before is left out."""
        self._low = max(self._low, low)
        while self._next is not None and self._next.time < low:
            self._next = next(self._recorded, None)

    def take(self, sent: Recorded) -> None:
        """Compare a message; those before and after what was recorded are left out."""
        if self._next is None or sent.time < self._low or self.difference:
            return
        if self._next.time < sent.time:
            self.difference = f"message {self._next.seq} is missing"
        elif self._next.time > sent.time:
            self.difference = f"message {sent.seq} is new"
        elif self._next.data != sent.data:
            self.difference = f"message {sent.seq}: {_difference(self._channel, self._next, sent)}"
        else:
            self.same += 1
            self._next = next(self._recorded, None)

    def end(self, high: int) -> None:
        """Nothing more is sent up to this capture time, ns."""
        if self._next is not None and self._next.time <= high and not self.difference:
            self.difference = f"message {self._next.seq} is missing"


def compare(
    port: str, channel: Channel, old: Iterable[Recorded], new: Iterable[Recorded], *, whole: bool
) -> Compared:
    """Byte for byte, up to the first difference. whole: whether both must be equally long."""
    same = 0
    for before, after in zip_longest(old, new):
        if before is None:
            what = f"message {after.seq} is new"
            return Compared(port, same, what if whole else "", lacks=after.time)
        if after is None:
            return Compared(port, same, f"message {before.seq} is missing" if whole else "")
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
