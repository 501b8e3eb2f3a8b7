"""The light of a camera's pictures over that of the first one, so that colours stay those of the people.

A lamp that is switched or dimmed changes nearly all pixels by one factor; people change some of them. The
factor is the median ratio to a reference picture, and counts if most pixels agree on it. Slow drifts of
daylight are left to colours that are learnt anew.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array

COARSE = 8
"""One pixel of so many in a row and column tells the light of a picture."""
CHANGE = 0.15
"""Smallest change of the logarithm of the light that counts."""
AGREEMENT = 0.15
"""Largest median deviation of the pixels' logarithms: with more, the camera moved or another room is seen."""
BLACK = 6.0
"""Smallest sum of a pixel's channels that tells a ratio, in both pictures."""
LONGEST = 16
"""Changes that are remembered."""


@dataclass(frozen=True, eq=False)
class Illumination:
    """reference: sums of channels of the picture with the last change, (n,); changes: time (ns) from which
    the light was so many times that of the first picture, ascending.
    """

    reference: Array | None = None
    changes: tuple[tuple[int, float], ...] = ()

    @property
    def light(self) -> float:
        """Of the last picture."""
        return self.changes[-1][1] if self.changes else 1.0

    def at(self, time: int) -> float:
        """Light of the picture of a time, ns, or of the oldest that is remembered."""
        known = [light for then, light in self.changes if then <= time] or [c[1] for c in self.changes[:1]]
        return known[-1] if known else 1.0

    def after(self, pixels: Array, time: int) -> Illumination:
        """With one more picture, (H, W, 3) u1, of a time, ns."""
        now = pixels[::COARSE, ::COARSE].sum(axis=-1, dtype=np.float32).ravel()
        if self.reference is None or self.reference.shape != now.shape:
            return Illumination(now, (*self.changes, (time, self.light))[-LONGEST:])
        told = (now >= BLACK) & (self.reference >= BLACK)
        if 2 * told.sum() < len(now):
            return self
        ratio = np.log(now[told] / self.reference[told])
        change = float(np.median(ratio))
        if abs(change) < CHANGE:
            return self
        agreed = float(np.median(np.abs(ratio - change))) <= AGREEMENT
        light = self.light * float(np.exp(change)) if agreed else self.light
        return Illumination(now, (*self.changes, (time, light))[-LONGEST:])


def in_usual_light(pixels: Array, light: float) -> Array:
    """Pixels (uint8) as they would be in the light of the first picture.

    light: theirs, relative to it; the pixels stay as they are if none can be.
    """
    if light == 1.0 or not light > 0.0:
        return pixels
    return np.asarray(cv2.convertScaleAbs(pixels, alpha=1 / light))
