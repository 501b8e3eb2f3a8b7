"""The words that a writer and one reader of a ring share: credit, releases, and a request to be woken."""

from __future__ import annotations

from collections.abc import Sequence
from struct import pack_into
from threading import Lock

from followspot.transport.ring.memory import Memory

ARENAS = 20
"""Most arenas of a ring: each at least doubles the size of a slot, from a page to the largest message."""
CONSUMED = 0
"""Word: messages that the reader has taken out of its queue. Stored by the reader."""
SENT = 1
"""Word: datagrams sent so far, which saves the reader a system call. Stored by the writer."""
WAITING = 2
"""Word: 1 if the writer asks for a wake-up. Set by the writer, cleared by the reader."""
_RELEASED = 3
_FENCE = Lock()


def fence() -> None:
    """Order this process's earlier stores before its later loads, as the other process sees them.

    Each side stores a word and then loads the other's; without a fence, both may miss it. Taking a lock is a
    full fence on x86; on machines with weaker order the time limit of the scheduler's sleep heals a miss.
    """
    _FENCE.acquire()
    _FENCE.release()


class Control:
    """8-byte words in shared memory, each stored by one side; the reader clears the request for a wake-up."""

    def __init__(self, memory: Memory, slots: int) -> None:
        self.memory = memory
        self.words = memoryview(memory.bytes).cast("Q")
        """`CONSUMED`, `SENT`, `WAITING`, and a word for each slot. Readers and writers index it themselves,
        because a method call at each message would cost more than the word."""
        self._slots = slots

    @staticmethod
    def size(slots: int) -> int:
        """Bytes of memory that the words for this many slots take."""
        return 8 * (_RELEASED + ARENAS * slots)

    def release_all(self, arena: int, stamps: Sequence[int]) -> None:
        """Store the stamps of all slots of an arena."""
        first = released_word(arena, self._slots)
        pack_into(f"{len(stamps)}Q", self.memory.bytes, 8 * first, *stamps)


def released_word(arena: int, slots: int) -> int:
    """Word: stamp of the last message released in the first slot of an arena; those of the others follow.

    It releases the messages before that one in the slot as well. Stored by the reader.
    """
    return _RELEASED + arena * slots
