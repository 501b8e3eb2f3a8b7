"""A person's height from people at large, from the size of the body, and from where it stands.

The size in a picture gives height and distance up to one error that stays the same for a person, because no
body has exactly the proportions of the model: pictures in a row do not average it. Where the feet are seen on
the floor, the distance needs no size, and the line of sight to the head's top gives the height.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from followspot import Array

USUAL, SPREAD = 1.72, 0.09
"""Mean and sigma of adults' heights, m."""
PROPORTION_SIGMA = 0.08
"""Relative sigma of a person's proportions and of the detector's boxes of it."""
CONTACT_SIGMA = 0.03
"""Sigma of a height by the feet that stays the same for a person: shoes, shadows, the way of walking, m."""
SMALLEST_SIGMA = 0.015
"""Of a height, because steps and hats change it, m."""
SIZES = 60.0
"""Pictures that the height by size is a mean of."""
CONTACTS = 40
"""Pictures that the height by the feet is taken from."""
LOW_QUANTILE = 0.3
"""Of these heights: feet that are not told from the floor make a person seem farther away, and taller."""
FIRST_CONTACTS = 4
"""Smallest number of them that counts."""


@dataclass(frozen=True, eq=False)
class Stature:
    """What is known of a person's height: mean by size (m) of `sizes` pictures and its sigma (m); heights by
    the feet (C,) m, newest last.
    """

    by_size: float = USUAL
    sizes: float = 0.0
    size_sigma: float = np.inf
    by_feet: Array = field(default_factory=lambda: np.empty(0))

    def sized(self, height: float, eye: float) -> Stature:
        """After a picture in which the body's size says this height, m; eye: height of the camera, m."""
        count = min(self.sizes + 1, SIZES)
        mean = self.by_size + (height - self.by_size) / count
        sigma = size_sigma(mean, eye) * (1 + 1 / count) ** 0.5
        return Stature(mean, count, sigma, self.by_feet)

    def stood(self, height: float) -> Stature:
        """After a picture in which the feet say this height, m."""
        return Stature(self.by_size, self.sizes, self.size_sigma, np.append(self.by_feet, height)[-CONTACTS:])

    @property
    def estimate(self) -> tuple[float, float]:
        """Mean and sigma of the height, m: the product of independent Gaussians."""
        mean = [USUAL, self.by_size]
        precision = [SPREAD**-2, self.size_sigma**-2]
        if len(self.by_feet) >= FIRST_CONTACTS:
            mean.append(float(np.quantile(self.by_feet, LOW_QUANTILE)))
            precision.append(CONTACT_SIGMA**-2)
        total = sum(precision)
        told = sum(m * p for m, p in zip(mean, precision, strict=True)) / total
        return told, max(SMALLEST_SIGMA, total**-0.5)


def size_sigma(height: float, eye: float) -> float:
    """Sigma of a height (m) that a body's size gives to a camera at the height `eye`, m.

    The distance is r = k h with an error of proportions in k, and h = eye + slope r: dh = (h - eye) h / eye
    dk / k. A camera at the height of the head knows the height, one without a floor nothing.
    """
    if eye <= 0:
        return np.inf
    return max(SMALLEST_SIGMA, PROPORTION_SIGMA * abs(height - eye) * height / eye)
