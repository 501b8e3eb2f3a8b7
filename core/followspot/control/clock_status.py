"""How the clock of a host differs from the one by which its run goes, as people want to know it."""

from __future__ import annotations

from dataclasses import dataclass

from followspot.ranges import Count, Figure

LIMIT_MS = 5.0
"""Offset, ms, from which on users are told to set their clocks."""


@dataclass(frozen=True)
class ClockStatus:
    """reference: the host by whose clock the run goes, "" where it is this one, or the only one.

    offset_ms: what is added to capture times here; round_trip_ms: of the slowest question that counts; half
    of it bounds the error; exchanges: questions that count, 0 where nothing is known.
    """

    reference: str = ""
    offset_ms: Figure = 0.0
    round_trip_ms: Figure = 0.0
    exchanges: Count = 0

    @property
    def warning(self) -> str:
        """What to tell the user; empty where all is well."""
        if self.reference and not self.exchanges:
            return f"its clock could not be compared with that of {self.reference}; times are as they are"
        if abs(self.offset_ms) < LIMIT_MS:
            return ""
        way = "behind" if self.offset_ms > 0 else "ahead of"
        return (
            f"its clock is {abs(self.offset_ms):.1f} ms {way} that of {self.reference}; capture times are "
            "corrected, but set the clocks of all hosts by NTP or PTP"
        )


class ClockWarnings:
    """Says each time that a clock is found to be off what it has not said before."""

    def __init__(self) -> None:
        self._told: ClockStatus | None = None

    def news(self, status: ClockStatus) -> str:
        """What to tell the user now; empty where there is nothing new."""
        if not status.warning:
            if abs(status.offset_ms) < LIMIT_MS / 2:  # one that is nearly off is not off again and again
                self._told = None
            return ""
        if self._told is not None and _alike(self._told, status):
            return ""
        self._told = status
        return status.warning


def _alike(told: ClockStatus, status: ClockStatus) -> bool:
    """Whether a warning says again what one has said."""
    compared = bool(told.exchanges) == bool(status.exchanges)
    return compared and abs(status.offset_ms - told.offset_ms) < LIMIT_MS
