"""The words that a writer and one reader of a ring share: credit, releases, and a request to be woken."""

from __future__ import annotations

from threading import Lock

import numpy as np

from followspot.messages import Array
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
        self._released: Array = np.frombuffer(memory.bytes, np.uint64)[_RELEASED:].reshape(ARENAS, slots)

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

    def released(self, arena: int) -> Array:
        """(slots,) uint64: stamp of the last message released in each slot. Stored by the reader."""
        row: Array = self._released[arena]
        return row

    @property
    def waiting(self) -> bool:
        """Whether the writer asks for a wake-up. Set by the writer, cleared by the reader."""
        return self._words[_WAITING] != 0

    @waiting.setter
    def waiting(self, asks: bool) -> None:
        self._words[_WAITING] = asks
