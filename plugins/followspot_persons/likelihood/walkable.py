"""Limits of space: the part of the floor where people can be (Weinrich et al. 2010, section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array

SIGMA = 0.1
"""How far beyond the limits a place is likely, m."""


@dataclass(frozen=True, eq=False)
class Walkable:
    """A convex part of the floor. normal: (E, 2), outwards of each edge; offset: (E,) m, n x on the edge."""

    normal: Array
    offset: Array

    @classmethod
    def within(cls, corners: Sequence[tuple[float, float]]) -> Walkable | None:
        """The convex hull of places, m; None without places: everywhere."""
        if not corners:
            return None
        hull = cv2.convexHull(np.array(corners, np.float32)).reshape(-1, 2).astype(float)
        along = np.roll(hull, -1, axis=0) - hull
        area = float(hull[:, 0] @ np.roll(hull[:, 1], -1) - hull[:, 1] @ np.roll(hull[:, 0], -1))
        outwards = np.sign(area) * np.column_stack([along[:, 1], -along[:, 0]])
        normal = outwards / np.hypot(*along.T)[:, None]
        return cls(normal, (normal * hull).sum(axis=1))

    def outside(self, place: Array) -> Array:
        """How far places (P, 2) are beyond the limits, m, (P,); 0 within."""
        return np.asarray(np.maximum((place @ self.normal.T - self.offset).max(axis=1), 0.0))

    def excludes(self, places: Array) -> bool:
        """Whether none of these places (P, 2) is within the limits."""
        return bool((self.outside(places) > SIGMA).all())

    def log_prior(self, place: Array) -> Array:
        """Logarithm of the prior of places (P, 2), up to a constant, (P,)."""
        return np.asarray(-0.5 * (self.outside(place) / SIGMA) ** 2)
