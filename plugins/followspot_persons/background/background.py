"""The room without people, as a median of pictures, and the foreground: regions that differ from it.

Pictures are kept at growing intervals, so that the median spans a minute, and a person who stands still for
some time does not become part of it. A shadow only darkens and keeps the colour, so it is no foreground
(Horprasert et al. 1999).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_persons.panorama import short_way

INTERVAL, LONGEST = 0.5, 4.0
"""Time between two kept pictures, first and at last, s."""
MOST = 16
"""Kept pictures; when there are as many, every second one is dropped and the interval doubles."""
FEWEST = 6
"""Kept pictures that make a background."""
SHADE, GLARE = 0.72, 1.15
"""Brightness over that of the background between which colours decide."""
CHROMA = 0.06
"""Difference of chromaticities, summed over channels, from which a colour is another one."""
NOISE = 6.0
"""Growth of this difference in dark pictures: times 1 / sum of channels."""
BLACK = 4.0
"""Added to each channel: black has no colour."""
ARMS, MARGIN = 0.6, 0.15
"""What is left out of a picture beside a person's axis and above the head, in heights of the upper body."""
COARSE = 8
"""One pixel of so many in a row and column tells the light of a picture."""
UNLIKE = 0.5
"""Share of foreground from which a picture does not show this background: the camera moved."""


@dataclass(frozen=True, eq=False)
class Background:
    """turn: columns of a full turn, 0 for a picture with borders; kept: pictures (H, W, 3) u1, oldest first;
    due: ns, when the next one is kept; interval: s; median: (H, W, 3) u1 of them, None if they are too few.
    """

    turn: int = 0
    kept: tuple[Array, ...] = ()
    due: int = 0
    interval: float = INTERVAL
    median: Array | None = None

    def after(self, pixels: Array, time: int, people: Array) -> Background:
        """With one more picture (H, W, 3) u1 of a time, ns, if it is due; people: (K, 4) px, upper bodies, in
        whose columns the background stays as it is.
        """
        if time < self.due:
            return self
        kept, interval = (*self.kept, self.without(pixels, people)), self.interval
        if len(kept) > MOST:
            kept, interval = (kept[::2], 2 * interval) if interval < LONGEST else (kept[1:], interval)
        median = (
            np.partition(np.stack(kept), len(kept) // 2, axis=0)[len(kept) // 2]
            if len(kept) >= FEWEST
            else None
        )
        return Background(self.turn, kept, time + round(interval * 1e9), interval, median)

    def without(self, pixels: Array, people: Array) -> Array:
        """The picture with the background in place of people."""
        out = pixels.copy()
        if self.median is None or self.median.shape != pixels.shape:
            return out
        columns = np.arange(pixels.shape[1])
        for x0, y0, x1, y1 in people.tolist():
            beside = np.abs(short_way(columns - (x0 + x1) / 2, self.turn)) < ARMS * (y1 - y0)
            top = max(0, int(y0 - MARGIN * (y1 - y0)))
            out[top:, beside] = self.median[top:, beside]
        return out

    def light(self, pixels: Array) -> float | None:
        """How bright the picture is over the background; None if it shows no such background."""
        if self.median is None or self.median.shape != pixels.shape:
            return None
        now, then = (p[::COARSE, ::COARSE].reshape(-1, 3) for p in (pixels, self.median))
        gain = float(np.median((now.sum(axis=1) + 1.0) / (then.sum(axis=1) + 1.0)))
        return gain if foreground(now, then, gain).mean() < UNLIKE else None


def foreground(pixels: Array, background: Array, light: float, shade: float = SHADE) -> Array:
    """Which pixels show something else than the background: (..., 3) u1 each -> (...) bool.

    light: how bright the picture is over the background; shade: least brightness over it in a shadow.
    """
    now = [channel + np.float32(BLACK * light) for channel in _channels(pixels)]
    then = [(channel + np.float32(BLACK)) * np.float32(light) for channel in _channels(background)]
    sum_now, sum_then = now[0] + now[1] + now[2], then[0] + then[1] + then[2]
    ratio = sum_now / sum_then
    blue, green, red = (np.abs(a / sum_now - b / sum_then) for a, b in zip(now, then, strict=True))
    chroma = blue + green + red
    return np.asarray((ratio < shade) | (ratio > GLARE) | (chroma > CHROMA + NOISE / sum_now))


def _channels(pixels: Array) -> Array:
    """The channels of pixels (..., 3) u1, one after the other: numpy adds up three columns slowly."""
    return np.moveaxis(pixels.astype(np.float32), -1, 0)
