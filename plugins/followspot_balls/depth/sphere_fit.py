"""The fit of one sphere of a known radius to the points of a depth image, and how well it explains them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array

STEPS = 4
"""Gauss-Newton steps."""
LEAST = 5
"""Points that a fit needs."""
FACE = 0.85
"""Radius over that of the sphere, seen from the camera, up to which its face is judged: beyond it, pixels
show a mixture of the sphere and what is behind it."""
RIM = (1.2, 1.7)
"""Radii over that of the sphere between which its surroundings are judged."""
STABLE = 1e-3
"""Information added to keep the equations solvable."""


class Fit(NamedTuple):
    """A sphere and its evidence."""

    center: Array
    """(3,) m, from the camera."""
    points: int
    """Number of points on it."""
    face: int
    """Number of points that were measured within its face."""
    residual: float
    """RMS distance of these along the line of sight from the surface, m; none counts more than the radius."""
    one_sided: float
    """Whether what touches it comes from one side, like the hand that holds a ball: 1, or from opposite
    sides, like the limb that it is a part of: 0. 1 if nothing touches it."""


def fitted(points: Array, foreground: Array, center: Array, radius: float, tolerance: float) -> Fit | None:
    """The sphere through the points near a first centre, (3,) m; None if there are too few.

    points: (N, 3) m, from the camera; foreground: (N,) bool; tolerance: their distance from the sphere, m.
    """
    count = 0
    for _ in range(STEPS):
        offset = points - center
        length = np.sqrt(np.vecdot(offset, offset))
        near = (np.abs(length - radius) <= tolerance) & (length > 0)
        count = int(np.count_nonzero(near))
        if count < LEAST:
            return None
        normal = offset[near] / length[near, None]
        center = center + np.linalg.solve(
            normal.T @ normal + STABLE * np.eye(3), normal.T @ (length[near] - radius)
        )
    return judged(points, foreground, center, radius, count)


def judged(points: Array, foreground: Array, center: Array, radius: float, count: int) -> Fit:
    """The evidence of a fitted sphere, from the lines of sight that pass near it; count: points on it."""
    distance = np.sqrt(np.vecdot(points, points))
    rays = points / distance[:, None]
    along = rays @ center
    aside = along[:, None] * rays - center
    beyond, square = distance - along, np.vecdot(aside, aside)
    face = square < (FACE * radius) ** 2
    error = np.minimum(np.abs(beyond[face] + np.sqrt(radius * radius - square[face])), radius)
    residual = float(np.sqrt(np.mean(error * error))) if len(error) else radius
    rim = foreground & (beyond < 0) & (square > (RIM[0] * radius) ** 2) & (square < (RIM[1] * radius) ** 2)
    sides = aside[rim] / np.sqrt(square[rim, None])
    mean = sides.sum(axis=0) / max(len(sides), 1)
    one_sided = float(np.sqrt(mean @ mean)) if len(sides) else 1.0
    return Fit(center, count, len(error), residual, one_sided)
