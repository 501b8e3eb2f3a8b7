"""Intrinsics of cameras without a lens calibration: a guess that bundle adjustment can start from.

Pixels are taken as square and the principal point as the middle of the picture. The lens is the candidate
with straightened points that fit the most epipolar geometries, which needs no focal length. Focal lengths are
tried.
"""

from __future__ import annotations

import numpy as np

from followspot import Camera
from followspot.errors import FollowspotError
from followspot.messages import Array
from followspot_calibrate.adjust import Free, Progress
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.hazards.planar import REMEDY, in_a_plane
from followspot_calibrate.wand.incremental_sfm import InitialReconstruction, Reconstruction, reconstruct
from followspot_calibrate.wand.pairs import Pair, match, trusted, working_rows

BENDS = (0.1, 0.05, 0.0, -0.05, -0.1, -0.15, -0.2, -0.25, -0.3, -0.4)
"""Candidates for the division model (Fitzgibbon 2001), radii over half the diagonal; a barrel is negative."""
FOCALS = (1.0, 0.7, 1.4, 0.5, 2.0, 2.8)
"""Focal lengths that are tried, over the longer side of the picture, the usual ones first."""
ZOOMS = (0.7, 1.0, 1.4)
"""Largest ratio of the focal length of a further camera to that of the first two."""
LIMIT = 0.005
"""Distance from an epipolar line of points that fit, over the longer side of the picture."""
WELL = 0.3
"""Strain below which no other focal length is tried, if all cameras found their place."""


def guess_intrinsics(sightings: Sightings, progress: Progress | None = None) -> InitialReconstruction:
    """Cameras from sightings alone. Raises FollowspotError if the points lie in a plane."""
    bend, pairs = best_bend(sightings)
    if in_a_plane(straightened(sightings, bend), pairs, sightings.sizes):
        raise FollowspotError(
            f"the points lie in one plane, from which unknown lenses cannot be found: {REMEDY}, "
            "or calibrate the intrinsics first"
        )
    fits = trusted(pairs, sightings.seen.shape)
    rows = working_rows(pairs, fits)
    pixel = np.where(fits[rows, :, None], sightings.pixel[rows], np.nan)
    best, least = None, np.inf
    for number, focal in enumerate(FOCALS):
        if progress is not None:
            progress(f"focal length {focal:g} x size", number / len(FOCALS))
        cameras = guessed_cameras(sightings, focal, bend)
        reconstruction = reconstruct(cameras, pixel, pairs, Free(focal=True, distortion=1), ZOOMS)
        cost = np.inf if reconstruction is None else mean_excess_error(reconstruction, pixel, sightings.sizes)
        if cost < least:
            best, least = reconstruction, cost
        if reconstruction is not None and len(reconstruction.placed) == len(cameras) and cost < WELL:
            break
    return InitialReconstruction(pairs, fits, {} if best is None else best.placed)


def best_bend(sightings: Sightings) -> tuple[float, list[Pair]]:
    """The lens that makes the most points fit the fundamental matrices, and these pairs."""
    longer = sightings.sizes.max(axis=1)
    tried = [(bend, match(straightened(sightings, bend), LIMIT * longer)) for bend in BENDS]
    return max(tried, key=lambda one: sum(pair.shared for pair in one[1]))


def straightened(sightings: Sightings, bend: float) -> Array:
    """Pixels without distortion by the division model: (N, C, 2) px."""
    middle = (sightings.sizes - 1) / 2
    away = sightings.pixel - middle
    r2 = np.square(away / np.linalg.norm(middle, axis=1)[:, None]).sum(axis=2, keepdims=True)
    return np.asarray(middle + away / (1 + bend * r2))


def guessed_cameras(sightings: Sightings, focal: float, bend: float) -> list[Camera]:
    """Cameras without poses. focal: over the longer side; bend: becomes k1, the same for small angles."""
    cameras = []
    for name, size in zip(sightings.cameras, sightings.sizes, strict=True):
        f, middle = focal * size.max(), (size - 1) / 2
        matrix = np.array([[f, 0, middle[0]], [0, f, middle[1]], [0, 0, 1]])
        distortion = np.array([bend * f**2 / (middle @ middle), 0, 0, 0, 0])
        width, height = size.tolist()
        cameras.append(Camera(name, "color", (width, height), matrix, distortion, np.eye(3), np.zeros(3)))
    return cameras


def mean_excess_error(reconstruction: Reconstruction, pixel: Array, sizes: Array) -> float:
    """Mean of the errors over twice `LIMIT`, each at most 1; a sighting without a point counts as 1."""
    seen = np.isfinite(pixel[..., 0])
    error = np.ones(seen.shape)
    numbers = sorted(reconstruction.placed)
    longer = sizes.max(axis=1)[numbers]
    error[:, numbers] = np.nan_to_num(
        np.minimum(reconstruction.residual / (2 * LIMIT * longer), 1.0), nan=1.0
    )
    return float(error[seen].mean()) if seen.any() else 1.0
