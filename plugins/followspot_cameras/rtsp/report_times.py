"""Capture times of the pictures of one server over all its sessions: by its reports, else by the arrival."""

from __future__ import annotations

from collections.abc import Callable

from followspot_cameras.rtsp.access_units import AccessUnit
from followspot_cameras.rtsp.rtp import SenderReport
from followspot_cameras.rtsp.sender_clock import SenderClock

OLDEST, EARLY = 10_000_000_000, 100_000_000
"""A picture that would be captured so long before it came, or so much after, ns, has a wrong report."""
TOLD = 50_000_000
"""Change of the offset of the clock that the user is told again, ns."""
DRIFT = 50e-6
"""Drift that the user is told: more than that of ordinary crystals."""
SMOOTH = 0.1
"""Share of a new delay in the mean delay of pictures."""


class ReportTimes:
    """Capture times, ns since 1970, which rise.

    wait: how long the first session may last without a report before the arrival counts, ns; say: tells the
    user about the sender's clock.
    """

    def __init__(self, wait: int, say: Callable[[str], None]) -> None:
        self._wait, self._say = wait, say
        self._clock = SenderClock(90_000)
        self._began = 0
        self._delay: float | None = None
        self._told: int | None = None
        self._last = -(1 << 62)
        self._arrival_said = self._drift_said = False

    def begin(self, rate: int, now: int) -> None:
        """Begin a session, whose RTP time stamps have another origin. rate: ticks per second; now: ns."""
        self._clock = SenderClock(rate)
        self._began = now

    def report(self, report: SenderReport, arrival: int) -> None:
        """Take a report, and say if the sender's clock is far off."""
        self._clock.add(report, arrival)
        offset = self._clock.offset
        if abs(offset - (self._told or 0)) > TOLD:
            self._told = offset
            self._say(f"its clock is {-offset / 1e6:+.0f} ms off, which is corrected")
        if abs(self._clock.drift) > DRIFT and not self._drift_said:
            self._drift_said = True
            self._say(f"its clock drifts by {-1e6 * self._clock.drift:+.0f} ppm, which is followed")

    def capture_time(self, unit: AccessUnit) -> int | None:
        """Time of a picture; None for one that cannot be placed yet, or not after the one before."""
        time = self._placed(unit)
        if time is None or time <= self._last:
            return None
        self._last = time
        return time

    def _placed(self, unit: AccessUnit) -> int | None:
        reported = self._clock.capture_time(unit.timestamp)
        if reported is not None and -EARLY <= unit.arrival - reported <= OLDEST:
            delay = unit.arrival - reported
            self._delay = delay if self._delay is None else self._delay + SMOOTH * (delay - self._delay)
            return reported
        if self._delay is not None:  # as late as its pictures were before
            return unit.arrival - round(self._delay)
        if reported is None and unit.arrival - self._began < self._wait:
            return None
        if not self._arrival_said:
            self._arrival_said = True
            why = "sends no reports of its clock" if reported is None else "sends wrong reports of its clock"
            self._say(f"{why}: capture times are those of the arrival")
        return unit.arrival
