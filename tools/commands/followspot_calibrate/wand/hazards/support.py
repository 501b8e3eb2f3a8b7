"""Number of points of the other cameras that one pose of a camera explains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array
from followspot_calibrate.wand.resection import resect

ENOUGH = 0.5
"""Share of a camera's points that a cause must explain; with 30 % of reflections 70 % are left."""
CLEARLY = 1.5
"""Smallest ratio of the points that a cause explains to those that fit without it."""
MOST = 1000
"""Points that are asked."""


@dataclass(frozen=True, eq=False)
class Support:
    """camera: with its new pose, None if it has none; share: of its points that this pose explains."""

    camera: Camera | None
    share: float


def support(camera: Camera, points: Array, pixel: Array) -> Support:
    """The best place of a camera with this lens. points: (N, 3); pixel: (N, 2) px; NaN if unknown."""
    rows = np.flatnonzero(np.isfinite(points[:, 0]) & np.isfinite(pixel[:, 0]))
    rows = rows[np.linspace(0, len(rows) - 1, min(len(rows), MOST)).astype(int)]
    found = resect(camera, points[rows], pixel[rows])
    return Support(None, 0.0) if found is None else Support(found[0], found[1] / len(rows))


def misfit(lens: Camera, points: Array, pixel: Array) -> float:
    """Median error of points seen through a lens from the best place, px; infinite without one."""
    placed = support(lens, points, pixel).camera
    if placed is None:
        return np.inf
    away = np.linalg.norm(project(placed, points) - pixel, axis=1)
    return float(np.median(np.nan_to_num(away[np.isfinite(pixel[:, 0] + points[:, 0])], nan=np.inf)))
