"""A clock that a test advances, and an edge within the process."""

from __future__ import annotations

from typing import TypeVar

from followspot.frame_times import SECOND
from followspot.message_checks.sealing import seal
from followspot.messages import Header, InvalidMessage, Message, stamped
from followspot.transport.codec import pack, unpack

M = TypeVar("M", bound=Message)


class VirtualClock:
    """Stamps messages as a source does: one frame after another, `rate` times a second."""

    def __init__(self, rate: float = 30.0, source: str = "test") -> None:
        self.period = round(SECOND / rate)
        self.source = source
        self.seq = 0
        self.time = 0

    def stamp(self, message: M) -> M:
        """The message, sealed and with the header of this moment."""
        return stamped(seal(message), Header(self.source, self.seq, self.time))

    def tick(self, frames: int = 1) -> None:
        """Go on by some frames; by a negative number, back."""
        self.seq += frames
        self.time += frames * self.period


class MemoryEdge:
    """An edge to another process without the process: messages pass through the wire format."""

    def __init__(self, kind: type[Message]) -> None:
        self.kind = kind
        self.arrived: list[Message] = []

    def send(self, message: Message) -> Message:
        """Pack, unpack, keep and return a stamped message. Raises InvalidMessage."""
        found = unpack(pack(seal(message)), self.kind)
        if not isinstance(found, Message):
            raise InvalidMessage(f"{found!r} arrived in place of a {self.kind.__name__}")
        self.arrived.append(found)
        return found
