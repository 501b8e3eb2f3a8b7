"""Points from an NPZ file of keypoints with confidence, as detectors write them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.array_files import read_arrays
from followspot.errors import InputError
from followspot.messages import Array
from followspot_calibrate.points_file.naming import names_of, sizes_of
from followspot_calibrate.sightings import Sightings

MOST_BYTES = 1_000_000_000
"""Bytes of the file, and of all its arrays."""
KEY = "keypoints"
VIEWS = "views_xywh"
"""Optional: (C, 4), the last two width and height of each picture."""


def read_keypoints(
    path: Path, cameras: Sequence[Camera], size: tuple[int, int] | None, confidence: float
) -> Sightings:
    """keypoints: (C, F, B, 3), camera, frame, point, [u v confidence]; NaN or little confidence: not seen.

    Raises InputError.
    """
    try:
        arrays = read_arrays(path, MOST_BYTES)
    except (OSError, ValueError) as error:
        raise InputError.of(f"{path} cannot be read: {error}", "needs an NPZ file") from None
    keypoints = arrays.get(KEY)
    if keypoints is None or keypoints.ndim != 4 or keypoints.shape[3] != 3 or keypoints.dtype.kind != "f":
        shape = "none" if keypoints is None else f"{keypoints.dtype} {keypoints.shape}"
        text = f'{path}: array "{KEY}" is {shape}'
        raise InputError.of(text, "needs floats (camera, frame, point, [u v confidence])")
    count, frames, points, _ = keypoints.shape
    keypoints = keypoints.astype(float).transpose(1, 2, 0, 3).reshape(frames * points, count, 3)
    unseen = ~np.isfinite(keypoints).all(axis=2) | (keypoints[..., 2] < confidence)
    pixel = np.where(unseen[..., None], np.nan, keypoints[..., :2])
    names = names_of(path, count, cameras)
    views = arrays.get(VIEWS)
    own = views is not None and views.shape == (count, 4) and _are_sizes(views[:, 2:])
    sizes = views[:, 2:].astype(int) if own and views is not None else sizes_of(path, names, cameras, size)
    frame, label = np.repeat(np.arange(frames), points), np.tile(np.arange(points), frames)
    return Sightings(names, sizes, frame, label, pixel)


def _are_sizes(sizes: Array) -> bool:
    """True if these numbers can be a picture's width and height."""
    return sizes.dtype.kind in "iuf" and bool(((sizes >= 1) & (sizes < 1 << 16)).all())
