"""The words that a writer and one reader of a ring share: credit, releases, and a request to be woken."""

from __future__ import annotations

from collections.abc import Sequence
from struct import pack_into
from threading import Lock

from followspot.transport.ring.memory import Memory

ARENAS = 20
"""Most arenas of a ring: each at least doubles the size of a slot, from a page to the largest message."""
_CONSUMED, _SENT, _WAITING, _RELEASED = range(4)
_FENCE = Lock()


def fence() -> None:
    """Order this process's earlier stores before its later loads, as the other process sees them.

    Each side stores a word and then loads the other's; without a fence, both may miss it. Taking a lock is a
    full fence on x86; on machines with weaker order the time limit of the scheduler's sleep heals a miss.
    """
    with _FENCE:
        pass


class Control:
    """8-byte words in shared memory, each stored by one side; the reader clears the request for a wake-up."""

    def __init__(self, memory: Memory, slots: int) -> None:
        self.memory = memory
        self._words = memoryview(memory.bytes).cast("Q")
        self._slots = slots

    @staticmethod
    def size(slots: int) -> int:
        """Bytes of memory that the words for this many slots take."""
        return 8 * (_RELEASED + ARENAS * slots)

    @property
    def consumed(self) -> int:
        """Messages that the reader has taken out of its queue. Stored by the reader."""
        return self._words[_CONSUMED]

    @consumed.setter
    def consumed(self, count: int) -> None:
        self._words[_CONSUMED] = count

    @property
    def sent(self) -> int:
        """Datagrams sent so far, which saves the reader a system call. Stored by the writer."""
        return self._words[_SENT]

    @sent.setter
    def sent(self, count: int) -> None:
        self._words[_SENT] = count

    def released(self, arena: int, slot: int) -> int:
        """Stamp of the last message released in a slot. Stored by the reader."""
        return self._words[_RELEASED + arena * self._slots + slot]

    def release(self, arena: int, slot: int, stamp: int) -> None:
        """Store that the message of this stamp, and those before it in the slot, are released."""
        self._words[_RELEASED + arena * self._slots + slot] = stamp

    def release_all(self, arena: int, stamps: Sequence[int]) -> None:
        """The same for all slots."""
        pack_into(f"{len(stamps)}Q", self.memory.bytes, 8 * (_RELEASED + arena * self._slots), *stamps)

    @property
    def waiting(self) -> bool:
        """Whether the writer asks for a wake-up. Set by the writer, cleared by the reader."""
        return self._words[_WAITING] != 0

    @waiting.setter
    def waiting(self, asks: bool) -> None:
        self._words[_WAITING] = asks
