"""How the clock of a host differs from the one by which its run goes, as people want to know it."""

from __future__ import annotations

from dataclasses import dataclass

LIMIT_MS = 5.0
"""Offset, ms, from which on users are told to set their clocks."""


@dataclass(frozen=True)
class ClockStatus:
    """reference: the host by whose clock the run goes, "" where it is this one, or the only one.

    offset_ms: what is added to capture times here; round_trip_ms: of the slowest question that counts; half
    of it bounds the error; exchanges: questions that count, 0 where nothing is known.
    """

    reference: str = ""
    offset_ms: float = 0.0
    round_trip_ms: float = 0.0
    exchanges: int = 0

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
