"""Points from an NPZ file of keypoints with confidence, as detectors write them."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.errors import InputError
from followspot.files import open_regular
from followspot.messages import Array
from followspot_calibrate.points_file.naming import names_of, sizes_of
from followspot_calibrate.sightings import Sightings

MOST_BYTES = 1_000_000_000
"""Bytes of all arrays in the file, unpacked."""
KEY = "keypoints"
_UNREADABLE = (
    *(OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error),
    *(NotImplementedError, RuntimeError, MemoryError),  # other compression, a password, a shape without bytes
)
VIEWS = "views_xywh"
"""Optional: (C, 4), the last two width and height of each picture."""


def read_keypoints(
    path: Path, cameras: Sequence[Camera], size: tuple[int, int] | None, confidence: float
) -> Sightings:
    """keypoints: (C, F, B, 3), camera, frame, point, [u v confidence]; NaN or little confidence: not seen.

    Raises InputError.
    """
    arrays = _arrays(path)
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


def _arrays(path: Path) -> dict[str, Array]:
    """The arrays of the file, none of them pickled."""
    try:
        with open_regular(path) as opened, zipfile.ZipFile(opened) as archive:
            unpacked = sum(member.file_size for member in archive.infolist())
        if unpacked > MOST_BYTES:
            raise InputError.of(f"{path} unpacks to {unpacked} bytes, at most {MOST_BYTES}")
        with open_regular(path) as opened, np.load(opened, allow_pickle=False) as file:
            return {name: file[name] for name in (KEY, VIEWS) if name in file}
    except _UNREADABLE as error:
        raise InputError.of(f"{path} cannot be read: {error}", "needs an NPZ file") from None
