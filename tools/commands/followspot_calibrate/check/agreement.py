"""Agreement of cameras about points, and the cameras that disagree."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from followspot import Camera
from followspot.geometry import Views, epipolar_distance, fundamental_matrix, undistort
from followspot.messages import Array
from followspot_calibrate.triangulation import leave_one_out, limits, residuals, triangulate

FEWEST = 20
"""Sightings that a camera is judged by."""
BLOCKS = 4
"""Parts of the time that are judged by themselves: a camera that was moved halfway is no good camera."""
STANDS_OUT = 2.0
"""Shift over scatter from which a camera has moved, rather than seen half-hidden targets."""
MAJORITY = 3
"""Cameras that must be left to say which other is wrong."""
LIMIT = 0.003
"""Error of a good camera over the longer side of its picture."""

Measure = Callable[[Array], float]
"""From residuals (N, 2) px to the score, px, that is compared with the limit."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """Agreement of C cameras about N points.

    pixel: (N, C, 2) px, the sightings; points: (N, 3) m, from the trusted cameras; residual: (N, C, 2) px, of
    each camera against the other trusted ones, NaN if unknown; score: (C,) px, compared with
    `limit`, NaN if a camera shares too few points; limit: (C,) px; suspects: numbers of the cameras that
    do not fit the others; at_odds: the others do not agree either; epipolar: (C, C) px, median distance of
    sightings from each other's epipolar line; shared: (C, C), points that both saw.
    """

    cameras: Sequence[Camera]
    pixel: Array
    points: Array
    residual: Array
    score: Array
    limit: Array
    suspects: tuple[int, ...]
    at_odds: bool
    epipolar: Array
    shared: Array

    @property
    def length(self) -> Array:
        """(N, C) px, lengths of the residuals."""
        return np.asarray(np.linalg.norm(self.residual, axis=2))

    @property
    def gross(self) -> Array:
        """(N, C) bool, sightings so far off that they show something else."""
        return np.asarray(self.length > limits(self.cameras))

    @property
    def inlier_residual(self) -> Array:
        """(N, C, 2) px, residuals without the gross errors."""
        return np.where(self.gross[..., None], np.nan, self.residual)


def typical_error(residual: Array) -> float:
    """Median length: half the sightings are nearer. For points that were measured well."""
    return float(np.median(np.linalg.norm(residual, axis=1)))


def bias(residual: Array) -> float:
    """The common part of residuals: length of their median, 0 if it does not stand out from their scatter.

    For targets: single sightings are off if people or light cover half of the target.
    """
    middle = np.median(residual, axis=0)
    scatter = float(np.median(np.linalg.norm(residual - middle, axis=1)))
    size = float(np.linalg.norm(middle))
    return size if size > STANDS_OUT * scatter else 0.0


def usual_limits(cameras: Sequence[Camera], limit: float | None) -> Array:
    """(C,) px: the limit that the user gave, or a share of each picture's longer side."""
    if limit is not None:
        return np.full(len(cameras), limit)
    return LIMIT * np.array([max(camera.size) for camera in cameras], float)


def agreement(
    cameras: Sequence[Camera], pixel: Array, time: Array, limit: Array, measure: Measure
) -> Agreement:
    """Hold each camera against the others; leave out the worst, as long as a majority is left.

    pixel: (N, C, 2) px with lens distortion, NaN if not seen; time: (N,) in any unit; limit: (C,) px.
    """
    block = np.argsort(np.argsort(time, kind="stable")) * BLOCKS // max(len(time), 1)
    trusted = list(range(len(cameras)))
    suspects: list[int] = []
    while True:
        points, residual = _against_trusted(cameras, pixel, trusted)
        score = np.array([worst_block(residual[:, one], block, measure) for one in range(len(cameras))])
        excess = np.nan_to_num(score / limit, nan=0.0)[trusted]
        if not len(trusted) or excess.max() <= 1 or len(trusted) <= MAJORITY:
            break
        suspects.append(trusted.pop(int(excess.argmax())))
    at_odds = bool(len(trusted) and excess.max() > 1)
    epipolar, shared = pair_distances(cameras, pixel)
    return Agreement(
        cameras, pixel, points, residual, score, limit, tuple(sorted(suspects)), at_odds, epipolar, shared
    )


def worst_block(residual: Array, block: Array, measure: Measure) -> float:
    """The largest measure of any part of the time with enough sightings, else of all; NaN for too few.

    residual: (N, 2) px; block: (N,) number of the part.
    """
    known = np.isfinite(residual[:, 0])
    if known.sum() < FEWEST:
        return np.nan
    parts = [residual[known & (block == number)] for number in range(BLOCKS)]
    return max(measure(part) for part in [*(p for p in parts if len(p) >= FEWEST), residual[known]])


def pair_distances(cameras: Sequence[Camera], pixel: Array) -> tuple[Array, Array]:
    """Median epipolar distance, px, and number of shared points of each pair: (C, C) each, symmetric."""
    count = len(cameras)
    distance, shared = np.full((count, count), np.nan), np.zeros((count, count), int)
    xy = np.full(pixel.shape, np.nan)
    for number, camera in enumerate(cameras):
        seen = np.isfinite(pixel[:, number, 0])
        xy[seen, number] = undistort(camera, pixel[seen, number])
    for i, j in combinations(range(count), 2):
        both = np.isfinite(xy[:, [i, j]]).all(axis=(1, 2))
        shared[i, j] = shared[j, i] = both.sum()
        if both.any():
            F = fundamental_matrix(cameras[i].projection, cameras[j].projection)
            distance[i, j] = distance[j, i] = np.median(epipolar_distance(F, xy[both, i], xy[both, j]))
    return distance, shared


def _against_trusted(cameras: Sequence[Camera], pixel: Array, trusted: Sequence[int]) -> tuple[Array, Array]:
    """Points (N, 3) m of the trusted cameras, and residuals (N, C, 2) px of each camera against these.

    A trusted camera is held against the others only.
    """
    chosen = [cameras[number] for number in trusted]
    found = triangulate(chosen, pixel[:, trusted])
    residual = residuals(Views(cameras), found.points, pixel)
    residual[:, trusted] = leave_one_out(chosen, pixel[:, trusted], found)
    return found.points, residual
