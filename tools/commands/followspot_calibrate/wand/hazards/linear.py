"""Points along a line: a wand that is waved to and fro on one way determines no poses."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array

FEWEST = 8
"""Points of a camera that are judged."""
THIN = 0.03
"""Spread across a line over that along it below which points lie on it: with an error of half a pixel, made
rooms were off by twice the usual and more below this."""
REFITS = 3
"""Fits without what lies off the line, which are reflections."""
OFF = 3.0
"""Spreads across the line beyond which a point lies off it."""

LEAST = 1e-9
"""px"""
ANGLES = np.arange(180) * np.pi / 180
"""Directions of the normals of lines that are tried first."""


def on_a_line(xy: Array, degree: int = 1) -> bool:
    """True if most cameras see nearly all points along one line, or a bent one through an unknown lens.

    xy: (N, C, 2) px with NaN; degree: 1 for a straight line, 2 for one bent by a lens.
    """
    seen = [view[np.isfinite(view).all(axis=1)] for view in xy.swapaxes(0, 1)]
    judged = [thickness(view, degree) for view in seen if len(view) >= FEWEST]
    return bool(judged) and 2 * sum(thick < THIN for thick in judged) > len(judged)


def thickness(xy: Array, degree: int) -> float:
    """Spread of points, (N, 2), across a line or a parabola over that along it: 1 for a round cloud.

    The spreads are medians, so that less than half of the points may be anywhere.
    """
    away = xy - np.median(xy, axis=0)
    normals = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    offsets = away @ normals.T
    apart = np.abs(offsets - np.median(offsets, axis=0))
    thinnest = int(np.median(apart, axis=0).argmin())
    kept = away[apart[:, thinnest] <= OFF * max(float(np.median(apart[:, thinnest])), LEAST)]
    across, along = np.zeros(0), np.zeros(0)
    for _ in range(REFITS):
        axes = np.linalg.svd(kept - kept.mean(axis=0), full_matrices=False)[2]
        along, across = (kept @ axes.T).T
        across = across - np.polynomial.Polynomial.fit(along, across, degree)(along)
        near = np.abs(across) <= OFF * max(float(np.median(np.abs(across))), LEAST)
        if near.all() or near.sum() < FEWEST:
            break
        kept = kept[near]
    length = float(np.median(np.abs(along - np.median(along))))
    return float(np.median(np.abs(across))) / length if length > 0 else 0.0
