"""The words that a writer and one reader of a ring share: credit, releases, and a request to be woken."""

from __future__ import annotations

from threading import Lock

import numpy as np

from followspot.messages import Array
from followspot.transport.ring.memory import Memory

ARENAS = 20
"""Most arenas in a ring's life: each at least doubles the slots, from a page to the largest message."""
_CONSUMED, _SENT, _WAITING, _RELEASED = range(4)
_FENCE = Lock()


def fence() -> None:
    """Order my earlier stores before my later loads as the other process sees them.

    Both sides store a word and then look at the other's; without a fence, both may miss it. To take a lock
    is a full fence on x86; on machines with weaker order the time limit of the runtime's sleep heals a miss.
    """
    with _FENCE:
        pass


class Control:
    """8-byte words in shared memory, each stored by one side only; the request is cleared by the other."""

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
        """Datagrams sent so far: a hint that saves the reader a look. Stored by the writer."""
        return self._words[_SENT]

    @sent.setter
    def sent(self, count: int) -> None:
        self._words[_SENT] = count

    def released(self, arena: int) -> Array:
        """(slots,) uint64: stamp of the last message of each slot that the reader let go; it stores them."""
        row: Array = self._released[arena]
        return row

    @property
    def waiting(self) -> bool:
        """Whether the writer asks to be woken. Set by the writer, cleared by the reader."""
        return self._words[_WAITING] != 0

    @waiting.setter
    def waiting(self, asks: bool) -> None:
        self._words[_WAITING] = asks
