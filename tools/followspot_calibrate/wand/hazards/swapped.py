"""Two cameras whose recordings, places or lenses stand for each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array
from followspot_calibrate.similarity import NEAR, on_a_line, similarity, spread
from followspot_calibrate.wand.hazards.support import support

MUCH_BETTER = 0.4
"""Error with the lenses or places exchanged over that without, below which they are."""


def exchanged_lenses(lenses: Sequence[Camera], points: Array, pixel: Array) -> list[tuple[int, int]]:
    """Pairs of cameras that both see the points much better through the lens of the other.

    lenses: what the room says of each camera; points: (N, 3), NaN where unknown; pixel: (N, C, 2) px.
    """
    own = [misfit(lens, points, pixel[:, i]) for i, lens in enumerate(lenses)]
    found: list[tuple[int, int]] = []
    for i, j in combinations(range(len(lenses)), 2):
        if any(i in pair or j in pair for pair in found) or _alike(lenses[i], lenses[j]):
            continue
        if not misfit(lenses[j], points, pixel[:, i]) < MUCH_BETTER * own[i]:
            continue
        if misfit(lenses[i], points, pixel[:, j]) < MUCH_BETTER * own[j]:
            found.append((i, j))
    return found


def misfit(lens: Camera, points: Array, pixel: Array) -> float:
    """Median error of points seen through a lens from the best place, px; infinite without one."""
    placed = support(lens, points, pixel).camera
    if placed is None:
        return np.inf
    away = np.linalg.norm(project(placed, points) - pixel, axis=1)
    return float(np.median(np.nan_to_num(away[np.isfinite(pixel[:, 0] + points[:, 0])], nan=np.inf)))


def exchanged_places(found: Array, known: Array) -> tuple[int, int] | None:
    """Two of the centres, (C, 3) m each, that fit where they are known to be once they are exchanged.

    None where they fit as they are, or no exchange makes them fit.
    """
    limit = NEAR * spread(known)
    if len(found) < 4 or on_a_line(found) or _apart(found, known) < limit:
        return None
    errors = {}
    for i, j in combinations(range(len(found)), 2):
        order = np.arange(len(found))
        order[[i, j]] = j, i
        errors[i, j] = _apart(found[order], known)
    best = min(errors, key=lambda pair: errors[pair])
    return best if errors[best] < limit else None


def _apart(found: Array, known: Array) -> float:
    """Root mean square distance after the best similarity, m."""
    away = similarity(found, known).points(found) - known
    return float(np.sqrt(np.square(away).sum(axis=1).mean()))


def _alike(one: Camera, other: Camera) -> bool:
    return bool(np.allclose(one.matrix, other.matrix) and np.allclose(one.distortion, other.distortion))
