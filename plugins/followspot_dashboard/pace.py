"""The lead of a chosen capture time: no more than the graph processes until the next one is due."""

from __future__ import annotations

from followspot_dashboard.gate import MAX_LEAD


class Pace:
    """Frames of one source: their interval in capture time, and their rate."""

    def __init__(self) -> None:
        self._newest = 0
        self._interval = 0
        self._frames = 0
        self._since = 0

    def add(self, captured: int) -> None:
        """A frame with this capture time, ns."""
        self._interval = captured - self._newest if self._newest else 0
        self._newest = captured
        self._frames += 1

    def ahead(self, now: int, period: int) -> int:
        """Capture time, ns, from the newest frame to a time that is reached within `period`, ns.

        now: of the monotonic clock; counts frames anew. Half a frame is added to whole ones, so that jitter
        of the capture times does not part the cameras.
        """
        elapsed = now - self._since
        frames = self._frames * period // max(1, elapsed)
        self._since, self._frames = now, 0
        return max(0, int((min(MAX_LEAD, max(1, frames)) - 0.5) * self._interval))
