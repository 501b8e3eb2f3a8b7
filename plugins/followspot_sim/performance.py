"""Base of the sources of a simulated performance: its frames, and their times."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any, TypeVar

from followspot import Message, Stage, at

M = TypeVar("M", bound=Message)


class Performance(Stage):
    """Base of sources with the parameters `frames`, `fps` and `realtime`."""

    _begun = 0
    """When it began, ns of the monotonic clock: with all others, in whichever workers they are."""

    @classmethod
    def nominal_rate(cls, params: Any) -> float:
        """The parameter `fps`, Hz."""
        rate: float = params.fps
        return rate

    def length(self) -> int | None:
        """Number of frames; None if they never end."""
        return self.params.frames or None

    def capture_time(self, number: int) -> int:
        """Number / fps, ns."""
        since: int = round(number * 1e9 / self.params.fps)
        return since

    def frames(self) -> Iterable[int]:
        """Numbers of the frames."""
        self._begun = self.context.begun()
        return range(self.params.frames) if self.params.frames else itertools.count()

    def at(self, frame: int, message: M) -> M:
        """A message with the number and time of its frame; with `realtime`, sent at the pace of the clock."""
        since = self.capture_time(frame)
        return at(since, message, seq=frame, due=self._begun + since if self.params.realtime else 0)
