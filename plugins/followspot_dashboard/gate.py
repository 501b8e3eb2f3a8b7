"""The gate: the taps of all processes agree on the previewed capture times through shared memory.

Pictures, blobs and tracks of one time belong together, so the taps choose together: when the period is over,
the tap of a source stores a capture time a few frames ahead, and every tap shows its first message from then
on. The page makes the file of shared words in its folder, and stores there whether a browser shows it.
"""

from __future__ import annotations

import mmap
import os
from pathlib import Path

FILE = "gate"
SOCKET = "previews"
"""File of the socket beside it that takes the previews of this host."""
WATCHED, MOMENT, BEFORE, NEXT = range(4)
"""Words: whether a browser shows the page; the next capture time to show, ns, and the previous one, which
some taps may not have reached; the monotonic time, ns, after which a tap may choose the next one. They are
hints: two taps that write at once cost one preview."""
SIZE = 32
MAX_LEAD = 8
"""Largest number of frames between the choice of a time and that time: those that are in flight between
stages."""
_BACKWARDS = 1_000_000_000
"""Backward jump of the capture time, ns, that discards a chosen time: a recording has started again."""


class Gate:
    """The shared words. Raises OSError if the file is not there."""

    def __init__(self, folder: Path) -> None:
        fd = os.open(folder / FILE, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW)
        try:
            self._memory = mmap.mmap(fd, SIZE)
        finally:
            os.close(fd)
        self.words = memoryview(self._memory).cast("q")

    @property
    def watched(self) -> bool:
        """Whether a browser shows the page, which stores this word."""
        return self.words[WATCHED] != 0

    @watched.setter
    def watched(self, shown: bool) -> None:
        self.words[WATCHED] = shown

    def moment(self, time: int) -> int:
        """The newest chosen time, ns, up to a capture time: each tap shows its first message from then on.

        Later than the capture time if none was chosen yet.
        """
        newest = self.words[MOMENT]
        return newest if time >= newest else self.words[BEFORE]

    def due(self, now: int, time: int) -> bool:
        """Whether the next time is to be chosen.

        now: ns of the monotonic clock; time: capture time of a source's newest message, ns.
        """
        words = self.words
        return now >= words[NEXT] and (time >= words[MOMENT] or time + _BACKWARDS < words[MOMENT])

    def choose(self, moment: int, next_at: int) -> None:
        """Choose a capture time, ns; the next one is due at `next_at`, ns of the monotonic clock."""
        self.words[NEXT] = next_at
        self.words[BEFORE] = self.words[MOMENT]
        self.words[MOMENT] = moment

    def close(self) -> None:
        """Release the shared memory."""
        self.words.release()
        self._memory.close()


def make_gate(folder: Path) -> Gate:
    """A new gate in a folder. Raises OSError."""
    (folder / FILE).write_bytes(bytes(SIZE))
    return Gate(folder)
