"""Two cameras with exchanged recordings, places or lenses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.adjust import Free, adjust
from followspot_calibrate.similarity import NEAR, on_a_line, similarity, spread
from followspot_calibrate.wand.hazards.support import misfit
from followspot_calibrate.wand.rounds import SCALE, RobustAdjustment

MUCH_BETTER = 0.25
"""Error with the lens or place of another camera over that with its own, below which it is that one."""
BETTER = 0.7
"""Error of all cameras with two lenses exchanged over that without, below which they are."""
GOOD = 0.5
"""px: median error that leaves nothing to explain."""
ALIKE = 0.03
"""Relative difference of focal lengths up to which two lenses are alike."""
TRIED = 10
"""Exchanges that are tried, those of the most different lenses."""
MOST = 120
"""Rows that are adjusted for that."""


def lens_of_another(
    number: int, lenses: Sequence[Camera], points: Array, pixel: Array
) -> tuple[int, int] | None:
    """The camera without a place, and another one, that both fit better with the lens of the other.

    lenses: what the room says of each camera; points: (N, 3), NaN if unknown; pixel: (N, C, 2) px.
    """
    own, seen = misfit(lenses[number], points, pixel[:, number]), pixel[:, number]
    errors = [misfit(lens, points, seen) for lens in lenses]
    other = int(np.argmin(errors))
    if other == number or not errors[other] < MUCH_BETTER * own:
        return None
    theirs = pixel[:, other]
    back = misfit(lenses[number], points, theirs) < misfit(lenses[other], points, theirs)
    return (number, other) if back else None


def exchanged_lenses(adjusted: RobustAdjustment, pixel: Array) -> tuple[int, int] | None:
    """Two placed cameras that fit much better once their lenses are exchanged and all are adjusted anew.

    pixel: (N, C, 2) px. Lenses that are alike, and errors below `GOOD`, are not asked about.
    """
    if not np.nanmedian(adjusted.distance) > GOOD:
        return None
    rows = np.flatnonzero(np.isfinite(adjusted.points[:, 0]))
    rows = rows[np.linspace(0, len(rows) - 1, min(len(rows), MOST)).astype(int)]

    def error(cameras: Sequence[Camera]) -> float:
        scale = SCALE * adjusted.sigma
        found = adjust(cameras, adjusted.points[rows], pixel[rows], Free(), scale=scale)
        return float(np.nanmedian(found.residual))

    focal = np.log([camera.matrix[0, 0] for camera in adjusted.cameras])
    pairs = [pair for pair in combinations(range(len(focal)), 2) if abs(np.diff(focal[[*pair]])) > ALIKE]
    pairs = sorted(pairs, key=lambda pair: -abs(focal[pair[0]] - focal[pair[1]]))[:TRIED]
    errors = {pair: error(_exchange(adjusted.cameras, pair)) for pair in pairs}
    best = min(errors, key=lambda pair: errors[pair], default=None)
    return best if best is not None and errors[best] < BETTER * error(adjusted.cameras) else None


def _exchange(cameras: Sequence[Camera], pair: tuple[int, int]) -> list[Camera]:
    """The cameras in place, two of them with the lens of the other."""
    found = list(cameras)
    for one, other in (pair, pair[::-1]):
        lens = cameras[other]
        found[one] = replace(cameras[one], matrix=lens.matrix, distortion=lens.distortion)
    return found


def exchanged_places(found: Array, known: Array) -> tuple[int, int] | None:
    """Two of the centres, (C, 3) m each, that fit their known places once they are exchanged.

    None if they fit as they are, or no exchange makes them fit.
    """
    as_is = _apart(found, known) if len(found) >= 4 and not on_a_line(found) else 0.0
    if as_is < NEAR * spread(known):
        return None
    errors = {}
    for i, j in combinations(range(len(found)), 2):
        order = np.arange(len(found))
        order[[i, j]] = j, i
        errors[i, j] = _apart(found[order], known)
    best = min(errors, key=lambda pair: errors[pair])
    return best if errors[best] < MUCH_BETTER * as_is else None


def _apart(found: Array, known: Array) -> float:
    """Root mean square distance after the best similarity, m."""
    away = similarity(found, known).points(found) - known
    return float(np.sqrt(np.square(away).sum(axis=1).mean()))
