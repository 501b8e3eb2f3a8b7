"""The last seconds of each port, packed, in bounded memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from heapq import merge
from typing import NamedTuple

from followspot.frame_times import to_ns, to_seconds


class KeptMessage(NamedTuple):
    """A packed message. number: of arrival, over all ports; time: capture time, ns; missing: messages of
    its port that never came, just before it.
    """

    number: int
    port: str
    time: int
    missing: int
    packed: bytes


class KeptMessages:
    """Holds of each port the messages whose capture times lie within the last seconds of its newest one.

    If they take more memory than allowed, the oldest messages of the port that takes the most leave first:
    pictures are held for a shorter time than tracks. period: s; limit: bytes.
    """

    def __init__(self, period: float, limit: int) -> None:
        self.bytes = self.messages = 0
        self._period = to_ns(period)
        self._limit = limit
        self._number = 0
        self._ports: dict[str, deque[KeptMessage]] = {}
        self._sizes: dict[str, int] = {}

    def put(self, port: str, time: int, missing: int, packed: bytes) -> KeptMessage:
        """Keep a message, and drop messages that are too old or too many. time: capture time, ns."""
        self._number += 1
        self.messages += 1
        message = KeptMessage(self._number, port, time, missing, packed)
        held = self._ports.setdefault(port, deque())
        held.append(message)
        self.bytes += len(packed)
        self._sizes[port] = self._sizes.get(port, 0) + len(packed)
        while abs(time - held[0].time) > self._period:  # a recording that begins anew goes back in time
            self._drop(port)
        while self.bytes > self._limit:
            several = [name for name, messages in self._ports.items() if len(messages) > 1]
            if not several:
                break
            self._drop(max(several, key=self._sizes.__getitem__))
        return message

    @property
    def ports(self) -> tuple[str, ...]:
        """The ports of which a message came."""
        return tuple(self._ports)

    def newest(self, port: str) -> int:
        """Capture time of the newest message of a port, ns."""
        return self._ports[port][-1].time

    def after(self, numbers: dict[str, int]) -> Iterator[KeptMessage]:
        """The messages that came after the one of this number of their port, in the order of arrival."""
        newer = (
            (message for message in held if message.number > numbers.get(message.port, 0))
            for held in self._ports.values()
        )
        return merge(*newer)

    def held(self) -> float:
        """Seconds that are held of the port of which the fewest are; 0 before the first message."""
        spans = (abs(held[-1].time - held[0].time) for held in self._ports.values() if held)
        return to_seconds(min(spans, default=0))

    def _drop(self, port: str) -> None:
        size = len(self._ports[port].popleft().packed)
        self.bytes -= size
        self._sizes[port] -= size
