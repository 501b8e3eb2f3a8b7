"""From pairs to a room: two cameras to begin with, then one after the other (H&Z, section 18.6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.adjust import Free, adjust
from followspot_calibrate.triangulation import triangulate
from followspot_calibrate.wand.pairs import FEWEST, Pair
from followspot_calibrate.wand.resection import relate, resect

BEGINNINGS = 12
"""Pairs with the most shared points that are tried as the first."""
ENOUGH = 3
"""Number of cameras from which on the data determine more than poses."""


@dataclass(frozen=True, eq=False)
class InitialReconstruction:
    """Cameras of a room before the adjustment of all sightings.

    pairs: of cameras; trusted: (N, C) bool, sightings that fit them; placed: the cameras that found a place,
    by number.
    """

    pairs: Sequence[Pair]
    trusted: Array
    placed: Mapping[int, Camera]


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """Cameras that found their place, by number, and the points that they see: (N, 3), NaN if unknown.

    residual: (N, P) px of the placed cameras in the order of their numbers.
    """

    placed: Mapping[int, Camera]
    points: Array
    residual: Array


def reconstruct(
    cameras: Sequence[Camera],
    pixel: Array,
    pairs: Sequence[Pair],
    free: Free,
    zooms: Sequence[float] = (1.0,),
) -> Reconstruction | None:
    """Places the cameras relative to each other; None if no pair can begin.

    cameras: with their intrinsics, their poses count for nothing; pixel: (N, C, 2) px without gross
    outliers; free: what the data may change on the way; zooms: factors of its focal length that are tried
    for each further camera. The first camera is the frame of reference and its distance to the second the
    unit of length. Cameras that too few points tie to the others stay out.
    """
    beginning = _begin(cameras, pixel, pairs)
    reconstruction = None if beginning is None else _improved(beginning, pixel, free)
    while reconstruction is not None:
        further = _next(cameras, pixel, reconstruction, zooms)
        if further is None:
            break
        reconstruction = _improved({**reconstruction.placed, **further}, pixel, free)
    return reconstruction


def _begin(cameras: Sequence[Camera], pixel: Array, pairs: Sequence[Pair]) -> dict[int, Camera] | None:
    """Two cameras with many shared points under wide angles, of which many help to place a third."""
    seen = np.isfinite(pixel[..., 0])
    worth, placed = 0.0, None
    for pair in sorted(pairs, key=lambda pair: -pair.shared)[:BEGINNINGS]:
        if pair.shared < FEWEST:
            break
        both = pair.first, pair.second
        rows = seen[:, both].all(axis=1)
        first, second = cameras[pair.first], cameras[pair.second]
        relation = relate(first, second, pixel[rows][:, both])
        helpful = 1 + int((seen[rows].sum(axis=1) > len(both)).sum())
        if relation is not None and relation.worth * helpful > worth:
            worth = relation.worth * helpful
            placed = {
                pair.first: replace(first, rotation=np.eye(3), translation=np.zeros(3)),
                pair.second: replace(second, rotation=relation.rotation, translation=relation.translation),
            }
    return placed


def _next(
    cameras: Sequence[Camera], pixel: Array, reconstruction: Reconstruction, zooms: Sequence[float]
) -> dict[int, Camera] | None:
    """The camera that shares the most points with the placed ones and finds its pose among them."""
    known = np.isfinite(reconstruction.points[:, :1]) & np.isfinite(pixel[..., 0])
    waiting = [i for i in np.argsort(-known.sum(axis=0)).tolist() if i not in reconstruction.placed]
    for i in waiting:
        rows = known[:, i]
        guesses = (zoomed(cameras[i], zoom) for zoom in zooms)
        found = [resect(guess, reconstruction.points[rows], pixel[rows, i]) for guess in guesses]
        best = max((f for f in found if f is not None), key=lambda f: f[1], default=None)
        if best is not None and 2 * best[1] >= rows.sum():
            return {i: best[0]}
    return None


def _improved(placed: Mapping[int, Camera], pixel: Array, free: Free) -> Reconstruction:
    """The placed cameras and the points that they see, adjusted."""
    numbers = sorted(placed)
    cameras, own = [placed[i] for i in numbers], pixel[:, numbers]
    found = triangulate(cameras, own)
    clean = np.where(found.used[..., None], own, np.nan)
    better = adjust(cameras, found.points, clean, free if len(placed) >= ENOUGH else Free())
    return Reconstruction(dict(zip(numbers, better.cameras, strict=True)), better.points, better.residual)


def zoomed(camera: Camera, factor: float) -> Camera:
    """The camera with another focal length and a lens that bends rays at the same pixels alike."""
    if factor == 1:
        return camera
    matrix = camera.matrix.copy()
    matrix[[0, 1], [0, 1]] *= factor
    powers = np.array([2, 4, 1, 1, 6])
    return replace(camera, matrix=matrix, distortion=camera.distortion * factor**powers)
