"""Heartbeats: when a worker or a host counts as silent."""

from __future__ import annotations

from collections.abc import Mapping

SILENCE = 1.5
"""Seconds without a message after which a running worker counts as hanging; it sends five a second."""
LONG_SILENCE = 10.0
"""Seconds without a message after which the log names a worker that nothing replaces."""
_PAUSE = 0.6
"""Seconds between two checks above which the observer itself was suspended."""


class Heartbeat:
    """Finds processes without a heartbeat. Time in which this process was suspended does not count."""

    def __init__(self) -> None:
        self._checked = 0.0
        self._observer_slept_at = 0.0

    def silent(self, heard: Mapping[str, float], now: float, longest: float = SILENCE) -> list[str]:
        """Names of those without a message for more than `longest`, s.

        heard: time of each one's last message, s, monotonic; now: s, monotonic.
        """
        if now - self._checked > _PAUSE:
            self._observer_slept_at = now
        self._checked = now
        return [name for name, at in heard.items() if now - max(at, self._observer_slept_at) > longest]
