"""Pictures of one trigger get one capture time: each picture's number tells its trigger."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from fractions import Fraction
from math import floor
from statistics import median

from followspot.frame_times import SECOND, exact_rate
from followspot.room import Sync

WINDOW = 31
"""Pictures whose times together tell the trigger of one number."""
SLOW = 100
"""Number of pictures over which the usual time from a trigger to its picture is averaged."""
EARLY = 0.25
"""A picture comes after its trigger; clocks may place it up to this part of a period before."""
DOUBT = 0.125
"""A camera whose pictures are nearer, in periods, to those of the trigger before or after is in doubt."""


class TriggerTimes:
    """Capture times of a camera that is triggered at a rate.

    shared: whether triggers come at whole periods of the hosts' clock. Then a picture is captured at the
    moment of its trigger; else at a time that its neighbours by number agree with.
    """

    def __init__(self, rate: float, say: Callable[[str], None], *, shared: bool) -> None:
        """say: tells the user once that the triggers of pictures are in doubt."""
        self._period = Fraction(SECOND) / exact_rate(rate)
        self._shared, self._say = shared, say
        self._late: deque[int] = deque(maxlen=WINDOW)
        """Of each picture: its time less that of its number, as if number 0 were captured at 0; ns."""
        self._ahead = 0
        """Number of the trigger less that of its picture."""
        self._settled = False
        self._usual = 0.0
        """From a trigger to the time of its picture, ns."""
        self._last = -(1 << 62)

    def capture_time(self, number: int, told: int, *, exact: bool) -> int:
        """Of the picture of a number, ns since 1970, later than the last one.

        told: its time by clocks, ns since 1970; exact: whether that is good to far less than a period.
        """
        self._late.append(told - self._moment(number))
        if not self._shared:
            time = told if exact else self._moment(number) + round(median(self._late))
        else:
            time = self._moment(number + self._offset(exact=exact))
        self._last = max(time, self._last + 1)
        return self._last

    def _moment(self, number: int) -> int:
        return int(number * self._period)

    def _offset(self, *, exact: bool) -> int:
        """Number of the trigger less that of the last picture.

        Clocks that are not exact tell it at the beginning, all pictures together; later, they must be off by
        more than half a period on the whole before a trigger counts as missed.
        """
        if exact or not self._settled:
            late = Fraction(self._late[-1] if exact else round(median(self._late)))
            self._ahead = floor(late / self._period + Fraction(EARLY))
            self._usual = float(late - self._ahead * self._period)
            self._settled = not exact and len(self._late) == WINDOW
            if self._settled:
                self._judge()
        else:
            late_now = float(median(self._late) - self._moment(self._ahead))
            missed = round((late_now - self._usual) / float(self._period))
            self._ahead += missed
            if not missed:
                self._usual += (late_now - self._usual) / SLOW
        return self._ahead

    def _judge(self) -> None:
        """Tell the user if pictures of another camera that are hardly later may count to the next trigger."""
        part = self._usual / float(self._period) + EARLY
        if not DOUBT <= part <= 1 - DOUBT:
            late = self._usual / 1e6
            self._say(
                f"its pictures come {late:.1f} ms after their triggers, or a period before: its clock does "
                "not tell which; if frame sets fall apart, write `match: time` into `sync` of the room"
            )


def trigger_times(sync: Sync | None, say: Callable[[str], None]) -> TriggerTimes | None:
    """For a camera of a room; None if pictures have the times that clocks tell. say: as above."""
    if sync is None or sync.match == "time" or not sync.rate:
        return None
    return TriggerTimes(sync.rate, say, shared=sync.trigger != "line")
