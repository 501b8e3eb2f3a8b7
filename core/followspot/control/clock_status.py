"""The offset of a host's clock from the run's reference clock, in ms, and the warnings about it."""

from __future__ import annotations

from dataclasses import dataclass

from followspot.valid_values.numbers import Count, Figure

LIMIT_MS = 5.0
"""Offset, ms, from which users are told to set their clocks."""


@dataclass(frozen=True)
class ClockStatus:
    """The status of a host's clock.

    reference: the run's reference host, "" if it is this host or there is only one; offset_ms: added to
    capture times on this host; round_trip_ms: of the slowest exchange used, half of which bounds the error;
    exchanges: number of exchanges used, 0 if the offset is unknown.
    """

    reference: str = ""
    offset_ms: Figure = 0.0
    round_trip_ms: Figure = 0.0
    exchanges: Count = 0

    @property
    def warning(self) -> str:
        """A warning for the user, "" if the clock is right."""
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
    """Gives each new warning about a clock once."""

    def __init__(self) -> None:
        self._last: ClockStatus | None = None

    def news(self, status: ClockStatus) -> str:
        """The warning to log now, "" if there is none or it was logged before."""
        if not status.warning:
            if abs(status.offset_ms) < LIMIT_MS / 2:  # hysteresis around the limit
                self._last = None
            return ""
        if self._last is not None and _alike(self._last, status):
            return ""
        self._last = status
        return status.warning


def _alike(earlier: ClockStatus, status: ClockStatus) -> bool:
    """True if the warnings of two statuses say the same."""
    compared = bool(earlier.exchanges) == bool(status.exchanges)
    return compared and abs(status.offset_ms - earlier.offset_ms) < LIMIT_MS
