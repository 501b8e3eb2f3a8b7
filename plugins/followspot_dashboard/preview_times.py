"""Capture times of previews, which are the same for all taps, and which messages are shown at them."""

from __future__ import annotations

import time
from typing import Protocol

from followspot_dashboard.gate import Gate
from followspot_dashboard.pace import Pace


class PreviewTimes(Protocol):
    """Decides for each message whether a tap shows it."""

    def is_shown(self, captured: int) -> bool:
        """Whether the message with this capture time, ns, is shown. Asked once of each message."""


class SharedTimes:
    """Times in the shared memory of a gate; leads: whether this tap chooses them."""

    def __init__(self, gate: Gate, period: int, *, leads: bool) -> None:
        """period: between two moments, ns."""
        self._gate = gate
        self._period = period
        self._pace = Pace() if leads else None
        self._shown = -1

    def is_shown(self, captured: int) -> bool:
        """The first message of each moment."""
        moment = self._gate.moment(captured)
        if self._pace is not None:
            self._lead(self._pace, captured)
        if captured >= moment != self._shown:
            self._shown = moment
            return True
        return False

    def _lead(self, pace: Pace, captured: int) -> None:
        """Choose the next time if it is due."""
        pace.add(captured)
        now = time.monotonic_ns()
        if self._gate.due(now, captured):
            self._gate.choose(captured + pace.ahead(now, self._period), now + self._period)


class PeriodicTimes:
    """Times at whole periods of capture time, equal on all hosts without communication."""

    def __init__(self, period: int) -> None:
        """period: between two moments, ns."""
        self._period = period
        self._shown = -1

    def is_shown(self, captured: int) -> bool:
        """The first message of each period."""
        number = captured // self._period
        come = number != self._shown
        self._shown = number
        return come
