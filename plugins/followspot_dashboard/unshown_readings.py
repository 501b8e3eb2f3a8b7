"""Inertial readings since the last preview, so that the lines of the page leave none of them out."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from followspot.inertial import Inertial
from followspot.messages import stamped

MAXIMUM_WAITING = 256
"""Messages that wait for a preview at most; the oldest are left out."""


class UnshownReadings:
    """The readings of one sensor that no preview has shown yet."""

    def __init__(self) -> None:
        self._waiting: deque[Inertial] = deque(maxlen=MAXIMUM_WAITING)

    def add(self, message: Inertial) -> None:
        """Keep a message until the next preview."""
        self._waiting.append(message)

    def take(self) -> Inertial:
        """All readings that wait, in one message with the header of the last. At least one must wait."""
        last = self._waiting[-1]
        joined = {
            name: np.concatenate([getattr(m, name) for m in self._waiting]) for name in last.array_names
        }
        self._waiting.clear()
        return stamped(replace(last, **joined), last.header)  # type: ignore[arg-type]  # arrays are no texts

    def clear(self) -> None:
        """Discard the readings: no browser shows them."""
        self._waiting.clear()
