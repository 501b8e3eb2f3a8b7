"""RTP packets in the order in which they were sent, whatever the order in which they came (RFC 3550, 6.3.1).

Packets in order are not held. Behind a missing one, packets wait for it, but not longer than `wait`.
"""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeVar

T = TypeVar("T")
WRAP = 1 << 16
MOST_HELD = 2048
"""Packets that wait at most: a second of a camera that sends 25 Mbit/s."""
RESTART = 1024
"""A packet that is so many numbers before the next one shows that the sender began to count anew."""


class _Held(NamedTuple, Generic[T]):
    packet: T
    since: int


class JitterBuffer(Generic[T]):
    """Orders packets by their numbers of 16 bits. wait: longest wait for a missing packet, ns.

    late: packets that came twice, or after they were given up.
    """

    def __init__(self, wait: int) -> None:
        self._wait = wait
        self._next: int | None = None
        """Number of the next packet, which counts on where the sender's begins again."""
        self._held: dict[int, _Held[T]] = {}
        """By number, in the order in which they came."""
        self.late = 0

    def add(self, sequence: int, packet: T, now: int) -> None:
        """Take a packet. now: by a steady clock, ns."""
        if self._next is None:
            self._next = sequence
        ahead = (sequence - self._next + WRAP // 2) % WRAP - WRAP // 2
        if ahead < -RESTART:
            self._held.clear()
            self._next, ahead = sequence, 0
        number = self._next + ahead
        if ahead < 0 or number in self._held:
            self.late += 1
            return
        self._held[number] = _Held(packet, now)

    def next(self, now: int) -> T | None:
        """The next packet in order; None if there is none, or one before it may still come. now: as above."""
        if not self._held:
            return None
        if self._next not in self._held:
            if self.due > now and len(self._held) <= MOST_HELD:
                return None
            self._next = min(self._held)
        found = self._held.pop(self._next)
        self._next += 1
        return found.packet

    @property
    def due(self) -> int:
        """When a missing packet is given up, ns by the steady clock; a packet must be held."""
        return next(iter(self._held.values())).since + self._wait

    @property
    def holds(self) -> bool:
        """Whether packets wait for a missing one."""
        return bool(self._held)
