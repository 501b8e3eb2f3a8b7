"""The last values of a function of the frame number, for the next camera that asks."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Recent(Generic[T]):
    """Calls `compute` once for each frame, though sources in several threads ask, and keeps `size` values."""

    def __init__(self, compute: Callable[[int], T], size: int = 32) -> None:
        self._compute, self._size = compute, size
        self._kept: dict[int, T] = {}
        self._lock = threading.Lock()

    def __call__(self, frame: int) -> T:
        """The value at a frame."""
        with self._lock:
            if frame not in self._kept:
                while len(self._kept) >= self._size:
                    del self._kept[next(iter(self._kept))]
                self._kept[frame] = self._compute(frame)
            return self._kept[frame]
