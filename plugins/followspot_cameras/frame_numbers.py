"""Rising numbers of a camera's frames, from block identifiers of GigE Vision or sequence numbers of V4L2."""

from __future__ import annotations

SHORT = (1 << 16) - 1
"""Largest block identifier of GigE Vision 1.x; the next is 1, for 0 is reserved (GigE Vision 2.0, 24.3)."""
FARTHEST = 1 << 14
"""Largest step ahead that counts as missing frames; a larger one, or one back, is another beginning."""


class FrameNumbers:
    """Rising numbers of frames, from the identifiers that the camera gives.

    largest: identifier after which the camera begins again at 1; 0 if it does not (64 bits).
    """

    def __init__(self, largest: int = SHORT) -> None:
        self._largest = largest
        self._identifier: int | None = None
        self.number = -1
        """Of the last frame."""
        self.restarts = 0
        """How often the camera began its numbers anew."""

    def next(self, identifier: int) -> int | None:
        """Take the next frame: gives how many are missing before it, and sets `number` to its number.

        None for the identifier of the last frame again; `number` then stays.
        """
        if self._identifier is None:
            missing = 0
        else:
            step = self._step(self._identifier, identifier)
            if step == 0:
                return None
            if not 0 < step <= FARTHEST:
                self.restarts += 1
                step = 1
            missing = step - 1
        self._identifier = identifier
        self.number += missing + 1
        return missing

    def connected_again(self, largest: int) -> None:
        """Take the next identifier as it comes: the camera was away, and numbers go on from here."""
        self._identifier, self._largest = None, largest

    def _step(self, before: int, now: int) -> int:
        """Identifiers from one to the other, on the circle from 1 to the largest."""
        if not self._largest or max(before, now) > self._largest:
            return now - before
        step = (now - before) % self._largest
        return step if step <= FARTHEST else now - before
