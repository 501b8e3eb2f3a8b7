"""What all sources of a simulated performance have in common: its frames, and their times."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator

from followspot import Stage


class Performance(Stage):
    """Base of sources with the parameters `frames`, `fps` and `realtime`."""

    def length(self) -> int | None:
        """Number of frames; None if they never end."""
        return self.params.frames or None

    def schedule(self) -> Iterator[tuple[int, int]]:
        """Frame numbers with their capture times in ns; with `realtime`, at the pace of the clock."""
        p, begin = self.params, time.monotonic()
        for frame in range(p.frames) if p.frames else itertools.count():
            if p.realtime and not self.context.pause(max(0.0, begin + frame / p.fps - time.monotonic())):
                return
            yield frame, round(frame * 1e9 / p.fps)
