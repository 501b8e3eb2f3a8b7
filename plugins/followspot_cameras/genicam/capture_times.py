"""Capture times of pictures in this host's clock, from the camera's own time stamps."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Literal

from followspot.sensors.device_clock import DeviceClock
from followspot_cameras.genicam.camera_clock import CameraClock, Reading

By = Literal["", "camera", "shared", "delay", "arrival"]
"""How times are told: by the camera's clock, which is read; by the camera's clock, which is this host's
(PTP, or a camera on this host); by its time stamps and the least delay on the way; by arrival. "" before
the first picture."""
ALLOWANCE = 2_000_000
"""A picture that would be captured before the camera was told to start, or after it came, by more than this,
ns, was not stamped by the clock that the camera tells."""
SHARED = 1_000_000_000
"""A picture that is at most this old, ns, by its time stamp and this host's clock shows that the camera's
clock is the same. A clock that was never set is not so near by chance."""
INTERVAL = 1_000_000_000
"""Between readings of the clock, ns."""
TAI = 37_000_000_000
"""The time of PTP less UTC, ns, since 2017: cameras tell the former, and the system's clock the latter."""
FOREIGN = 3
"""First pictures that all contradict the clock which the camera tells: another clock stamps them."""
FIRST, THEN = 8, 3
"""Readings one after the other, at the beginning and then every time: one of them is likely to be quick."""


class CaptureTimes:
    """Capture times, ns since 1970, which rise. read: a timed reading of the camera's clock, None if none."""

    def __init__(self, read: Callable[[], Reading | None]) -> None:
        self.by: By = ""
        self.clock = CameraClock()
        self._delays = DeviceClock()
        self._read: Callable[[], Reading | None] | None = read
        self._due = 0
        self._started = 0
        self._contradictions: int | None = 0
        """Of the pictures so far; None once one of them agreed with the clock that the camera tells."""
        self._last = -(1 << 62)

    @property
    def exact(self) -> bool:
        """Whether the last time is the camera's own, in this host's clock."""
        return self.by in ("camera", "shared")

    def update(self, now: int) -> None:
        """Read the camera's clock if it is time to, ns by the steady clock."""
        if self._read is None or now < self._due:
            return
        self._due = now + INTERVAL
        for _ in range(THEN if self.clock.known else FIRST):
            reading = self._read()
            if reading is None:
                self._read = None
                return
            self.clock.add(reading)

    def start(self, now: int) -> None:
        """Note that the camera is told to start, ns by the steady clock."""
        self._started = now

    def capture_time(self, camera_time: int | None, arrival: int) -> int:
        """Of a picture. camera_time: by the camera's clock, None if it says none; arrival: steady; ns."""
        epoch = time.time_ns() - time.monotonic_ns()
        self.by, steady = self._told(camera_time, arrival, epoch)
        self._last = max(steady + epoch, self._last + 1)
        return self._last

    def _told(self, camera_time: int | None, arrival: int, epoch: int) -> tuple[By, int]:
        """How the time is told, and the time by the steady clock, ns. epoch: 1970 less its zero."""
        if camera_time is None:
            return "arrival", arrival
        delayed = self._delays.capture_time(camera_time, arrival)
        if self.clock.known:
            steady = self.clock.steady_time(camera_time)
            if self._agrees(self._started - ALLOWANCE <= steady <= arrival + ALLOWANCE):
                return "camera", steady
        else:
            for steady in (camera_time - epoch, camera_time - epoch - TAI):
                if -ALLOWANCE <= arrival - steady <= SHARED:
                    return "shared", steady
        return ("arrival", arrival) if delayed is None else ("delay", delayed)

    def _agrees(self, possible: bool) -> bool:
        """Whether the clock that the camera tells stamps its pictures. possible: this one, by its time.

        A clock that began when the pictures did gives possible times after a while, which are all wrong.
        """
        if self._contradictions is None:
            return possible
        if self._contradictions < FOREIGN:
            self._contradictions = None if possible else self._contradictions + 1
        return self._contradictions is None
