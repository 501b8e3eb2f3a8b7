"""A person's height from people at large, from the size of the body, and from where it stands.

The size in a picture gives height and distance up to one error that stays the same for a person, because no
body has exactly the proportions of the model: pictures in a row do not average it. Where the feet are seen on
the floor, the distance needs no size, and the line of sight to the head's top gives the height.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from followspot import Array, Camera
from followspot_persons.body.standing import knows_floor, standing

USUAL, SPREAD = 1.72, 0.09
"""Mean and sigma of adults' heights, m."""
PROPORTION_SIGMA = 0.08
"""Relative sigma of a person's proportions and of the detector's boxes of it."""
CONTACT_SIGMA = 0.03
"""Sigma of a height by the feet that stays the same for a person: shoes, shadows, the way of walking, m."""
SMALLEST_SIGMA = 0.015
"""Of a height, because steps and hats change it, m."""
LOWEST, HIGHEST = 1.3, 2.2
"""Heights that a box can give, m; another is not of an upper body."""
SIZES = 60
"""Pictures that the height by size is the median of."""
CONTACTS = 40
"""Pictures that the height by the feet is taken from."""
LOW_QUANTILE = 0.3
"""Of these heights: feet that are not told from the floor make a person seem farther away, and taller."""
FIRST_CONTACTS = 4
"""Smallest number of them that counts."""


@dataclass(frozen=True, eq=False)
class Stature:
    """What is known of a person's height: heights by the body's size (S,) m, their weights (S,), and the
    sigma of their median, m; heights by the feet (C,) m; newest last.
    """

    sizes: Array = field(default_factory=lambda: np.empty(0))
    weights: Array = field(default_factory=lambda: np.empty(0))
    size_sigma: float = np.inf
    by_feet: Array = field(default_factory=lambda: np.empty(0))

    @property
    def by_size(self) -> float:
        """Height by the body's size, m: the median, for some boxes are of heads alone."""
        return weighted_median(self.sizes, self.weights) if len(self.sizes) else USUAL

    def sized(self, height: float, eye: float, weight: float = 1.0) -> Stature:
        """After a picture in which the body's size says this height, m; eye: height of the camera, m; weight:
        how surely, 0 to 1.

        The height must not depend on what was known before, or a first mistake would confirm itself.
        """
        sizes = np.append(self.sizes, height)[-SIZES:]
        weights = np.append(self.weights, weight)[-SIZES:]
        sigma = size_sigma(weighted_median(sizes, weights), eye) * (1 + 1 / weights.sum()) ** 0.5
        return Stature(sizes, weights, sigma, self.by_feet)

    def stood(self, height: float | None) -> Stature:
        """After a picture in which the feet say this height, m; None if they are not seen."""
        if height is None:
            return self
        return replace(self, by_feet=np.append(self.by_feet, height)[-CONTACTS:])

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


def weighted_median(values: Array, weights: Array) -> float:
    """The value with half of the weight on either side, between two if they share the middle. (N,) each."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    middle = np.searchsorted(below, below[-1] * np.array([0.5 - 1e-9, 0.5 + 1e-9]))
    return float(values[order[np.minimum(middle, len(order) - 1)]].mean())


def size_sigma(height: float, eye: float) -> float:
    """Sigma of a height (m) that a body's size gives to a camera at the height `eye`, m.

    The distance is r = k h with an error of proportions in k, and h = eye + slope r: dh = (h - eye) h / eye
    dk / k. A camera at the height of the head knows the height, one without a floor nothing.
    """
    if eye <= 0:
        return np.inf
    return max(SMALLEST_SIGMA, PROPORTION_SIGMA * abs(height - eye) * height / eye)


def sized(stature: Stature, camera: Camera, box: Array, weight: float = 1.0) -> Stature:
    """What is known after a box (4,) px of the upper body, head top to waist: people stand on the floor.

    weight: how surely the box spans the upper body, 0 to 1; 0 if its size was not measured.
    """
    if not weight or not knows_floor(camera) or not is_of_adult(camera, box):
        return stature
    return stature.sized(float(standing(camera, box[None])[1][0]), float(camera.center[2]), weight)


def is_of_adult(camera: Camera, box: Array) -> bool:
    """Whether a box (4,) px can be of the upper body of an adult who stands on the floor.

    Of 4404 boxes of upper bodies in 76 rendered recordings all are, of 552 others 439.
    """
    return not knows_floor(camera) or bool(LOWEST < standing(camera, box[None])[1][0] < HIGHEST)
