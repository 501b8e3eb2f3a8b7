"""Points in a plane: they determine poses of cameras with known lenses, and hardly any unknown lens."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot.messages import Array
from followspot_calibrate.wand.pairs import FEWEST, MOST, Pair

PLANE = 0.9
"""Share of the points of a pair that fit one homography, from which on they lie in a plane."""
LIMIT = 0.005
"""Distance of points that fit, over the longer side of the picture."""
JUDGED = 12
"""Number of examined pairs, those with the most points."""
FLAT = 0.05
"""Thickness of the points over their second extent below which they are near a plane."""
REMEDY = "wave up and down as well as to and fro, through the whole depth of the room"


def in_a_plane(xy: Array, pairs: Sequence[Pair], sizes: Array) -> bool:
    """True if most pairs see all their points in a plane. xy: (N, C, 2) px undistorted; sizes: (C, 2) px."""
    judged = sorted((pair for pair in pairs if pair.shared >= FEWEST), key=lambda pair: -pair.shared)[:JUDGED]
    limit = LIMIT * sizes.max(axis=1)
    return 2 * sum(_planar(xy, pair, limit) for pair in judged) > len(judged)


def flatness(points: Array) -> float:
    """Thickness over second extent of points, (N, 3) with NaN: 0 in a plane, 1 as thick as wide."""
    known = points[np.isfinite(points[:, 0])]
    if len(known) < 3:
        return 0.0
    away = known - np.median(known, axis=0)
    near = np.linalg.norm(away, axis=1) < 3 * np.median(np.linalg.norm(away, axis=1))
    strength = np.linalg.svd(away[near] - away[near].mean(axis=0), compute_uv=False)
    return float(strength[2] / strength[1]) if strength[1] > 0 else 0.0


def _planar(xy: Array, pair: Pair, limit: Array) -> bool:
    """True if one homography explains the points that agree on an epipolar geometry (H&Z, section 11.9.2)."""
    import cv2

    rows = pair.rows[pair.agree]
    rows = rows[np.linspace(0, len(rows) - 1, min(len(rows), MOST)).astype(int)]
    first, second = xy[rows, pair.first], xy[rows, pair.second]
    largest = float(max(limit[pair.first], limit[pair.second]))
    H, inlier = cv2.findHomography(first, second, cv2.USAC_MAGSAC, largest)
    return H is not None and float(inlier.mean()) >= PLANE
