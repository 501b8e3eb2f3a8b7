"""The time of a device's own clock in that of this host, from when its messages arrive."""

from __future__ import annotations

WINDOW = 10_000_000_000
"""Time after which an old delay is forgotten, ns: clocks of devices drift by less than 1 ms in it."""
RESTART = 1_000_000_000
"""A device whose time jumps back, or ahead of this host's, by more than this, ns, was restarted."""
LEAST = 1000
"""Smallest interval of capture times, ns."""


class DeviceClock:
    """Capture times, which rise: device time plus the least offset of the last 10 to 20 s.

    The offset is that of the clocks and the delay on the way, which varies; the least one is nearest to its
    constant part, which no receiver can tell from the offset of the clocks.

    restarts: of the device; interval: device time between the last two messages, ns, 0 if it is not known.
    """

    def __init__(self) -> None:
        self.restarts = 0
        self.interval = 0
        self._device: int | None = None
        self._arrival = 0
        self._last = -(1 << 62)
        self._begin = 0
        self._least: int | None = None
        self._before: int | None = None

    def capture_time(self, device: int | None, arrival: int) -> int | None:
        """Capture time of a message by this host's clock; None if it is not later than the last one.

        device: None for one that does not say; arrival: both ns.
        """
        self.interval = 0
        if device is not None:
            ahead = 0 if self._device is None else device - self._device - max(0, arrival - self._arrival)
            if self._device is not None and (device < self._device - RESTART or ahead > RESTART):
                self.restarts += 1
                self._device = self._least = self._before = None
            if self._device is not None:
                if device <= self._device:
                    return None
                self.interval = device - self._device
            self._device, self._arrival = device, arrival
        told = arrival if device is None else device + self._offset(arrival - device, arrival)
        self._last = max(told, self._last + LEAST)
        return self._last

    def _offset(self, offset: int, arrival: int) -> int:
        """The least offset, with one more."""
        if self._least is None or not -WINDOW <= arrival - self._begin <= WINDOW:
            self._before, self._least, self._begin = self._least, offset, arrival
        self._least = min(self._least, offset)
        return self._least if self._before is None else min(self._least, self._before)
