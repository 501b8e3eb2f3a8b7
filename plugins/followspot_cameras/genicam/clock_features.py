"""Reads a camera's clock through its features: latches it, then reads the latched value (SFNC 2.7)."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass

from followspot.frame_times import SECOND
from followspot_cameras.genicam.camera_clock import Reading

LATCHES = (
    ("TimestampLatch", "TimestampLatchValue"),
    ("GevTimestampControlLatch", "GevTimestampValue"),
    ("TimestampLatch", "GevTimestampValue"),
    ("TimestampLatch", "Timestamp"),
)
"""Command that latches the clock and the feature that tells it: of SFNC 2, of GigE Vision 1, of both, of USB3
Vision before SFNC 2."""
FREQUENCY = "GevTimestampTickFrequency"


@dataclass(frozen=True)
class ClockFeatures:
    """The features of a camera's clock; frequency: units of its time in a second."""

    latch: str
    value: str
    frequency: int

    def read(self, execute: Callable[[str], None], read: Callable[[str], str]) -> Reading | None:
        """A timed reading: the clock is latched between `before` and `after`; None if the camera refuses."""
        try:
            before = time.monotonic_ns()
            execute(self.latch)
            after = time.monotonic_ns()
            return Reading(nanoseconds(int(read(self.value)), self.frequency), before, after)
        except ValueError:
            return None


def clock_features(names: Collection[str], read: Callable[[str], str]) -> ClockFeatures | None:
    """Clock features of a camera; None if its clock cannot be read. read: gives the value of a feature."""
    for latch, value in LATCHES:
        if latch in names and value in names:
            return ClockFeatures(latch, value, frequency(names, read))
    return None


def frequency(names: Collection[str], read: Callable[[str], str]) -> int:
    """Units of the camera's time in a second; 10^9 if it does not say, as SFNC 2 has it."""
    try:
        told = int(float(read(FREQUENCY))) if FREQUENCY in names else 0
    except (ValueError, OverflowError):  # no number, or none that is finite
        told = 0
    return told if told > 0 else SECOND


def nanoseconds(ticks: int, frequency: int) -> int:
    """A time of the camera, ns; exact, because a float holds no time since 1970 to the nanosecond."""
    return ticks if frequency == SECOND else ticks * SECOND // frequency
