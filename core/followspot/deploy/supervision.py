"""When a worker counts as hanging, and how long to wait before one that died is started again."""

from __future__ import annotations

from collections.abc import Mapping

SILENCE = 1.5
"""Seconds without a word after which a running worker counts as hanging; they speak five times a second."""
_FIRST_WAIT, _LONGEST_WAIT = 0.1, 5.0
"""Seconds before the first restart, and before any; it doubles each time."""
_ROW = 10.0
"""Seconds between two deaths of a worker within which they count as in a row."""
_PAUSE = 0.6
"""Seconds between two looks that say that it was the observer who slept."""


class BackOff:
    """How long to wait before a worker that died is started again: longer for deaths in a row."""

    def __init__(self) -> None:
        self._died: dict[str, float] = {}
        self._row: dict[str, int] = {}

    def wait(self, name: str, now: float) -> float:
        """Seconds; now: when it died, s. Who lived for a while before begins with a short wait again."""
        in_a_row = now - self._died.get(name, -_ROW) < _ROW
        self._row[name] = self._row[name] + 1 if in_a_row else 0
        self._died[name] = now
        return float(min(_LONGEST_WAIT, _FIRST_WAIT * 2 ** min(self._row[name], 30)))


class Pulse:
    """Listens for the heartbeat of workers; pauses of the listener itself are nobody's fault."""

    def __init__(self) -> None:
        self._looked = 0.0
        self._slept_until = 0.0

    def silent(self, heard: Mapping[str, float], now: float) -> list[str]:
        """Who has not been heard for too long. heard: when each last was, s; now: the time, s."""
        if now - self._looked > _PAUSE:
            self._slept_until = now
        self._looked = now
        return [name for name, at in heard.items() if now - max(at, self._slept_until) > SILENCE]
