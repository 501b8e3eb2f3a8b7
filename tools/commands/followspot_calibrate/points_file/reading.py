"""Which format a file of points is in, and the checks that all formats share."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.errors import InputError
from followspot_calibrate.points_file.csv_points import read_csv
from followspot_calibrate.points_file.keypoints import read_keypoints
from followspot_calibrate.points_file.svoboda import read_svoboda
from followspot_calibrate.sightings import Sightings

FORMATS = (
    "CSV frame,camera,u,v[,point]; NPZ with keypoints (camera, frame, point, [u v confidence]); "
    "folder with points.dat, IdMat.dat and Res.dat"
)
BEYOND = 0.1
"""Share of the points of two cameras beyond their pictures from which on the cameras may be exchanged."""
FAR_OUTSIDE = 0.5
"""Share of the picture's size by which a point may lie outside it; farther off it was not seen there."""


def read_points(
    path: Path,
    cameras: Sequence[Camera] = (),
    *,
    size: tuple[int, int] | None = None,
    confidence: float = 0.5,
) -> Sightings:
    """Sightings of points. Raises InputError with file and line.

    cameras: of the room, in its order, if there is one already; else the file names them. size: px, of all
    pictures, if neither room nor file has it; confidence: keypoints below it count as not seen.
    """
    if path.is_dir():
        found = read_svoboda(path, cameras)
    elif path.suffix.lower() == ".npz":
        found = read_keypoints(path, cameras, size, confidence)
    elif path.suffix.lower() in (".csv", ".txt"):
        found = read_csv(path, cameras, size)
    else:
        raise InputError.of(f"{path} is no file of points in a known format", f"known: {FORMATS}")
    return _checked(path, found, cameras)


def _checked(path: Path, found: Sightings, cameras: Sequence[Camera]) -> Sightings:
    """The sightings, in pictures of the size they are said to have."""
    for camera, size in zip(cameras, found.sizes.tolist(), strict=True) if cameras else ():
        if camera.size != tuple(size):
            text = f"{path}: pictures of {camera.name} have {size[0]}x{size[1]} px, in the room {camera.size}"
            raise InputError.of(text, "mend the size in the room file, or scale the points")
    _require_own_pictures(path, found)
    margin = FAR_OUTSIDE * found.sizes
    outside = np.any((found.pixel < -margin) | (found.pixel > found.sizes + margin), axis=2)
    for number, name in enumerate(found.cameras):
        share = outside[:, number].sum() / max(1, found.seen[:, number].sum())
        if share > FAR_OUTSIDE:
            width, height = found.sizes[number]
            text = f"{path}: most points of {name} lie outside its picture of {width}x{height} px"
            raise InputError.of(text, "mend the size in the room file, or give --size")
    return Sightings(
        found.cameras,
        found.sizes,
        found.frame,
        found.label,
        np.where(outside[..., None], np.nan, found.pixel),
    )


def _require_own_pictures(path: Path, found: Sightings) -> None:
    """Raises InputError if points lie outside of some cameras' pictures, but inside of others' sizes."""
    beyond = np.array([np.any((found.pixel < -1) | (found.pixel > size), axis=2) for size in found.sizes])
    share = beyond.sum(axis=1) / np.maximum(1, found.seen.sum(axis=0))
    own = np.diagonal(share)
    for number, other in combinations(range(len(found.cameras)), 2):
        exchanged = share[number, other] + share[other, number]
        if own[number] + own[other] > max(BEYOND, 2 * exchanged):
            one, two = found.cameras[number], found.cameras[other]
            text = f"{path}: {one} and {two} see points beyond their pictures, but not beyond each other's"
            raise InputError.of(text, "exchange their points, or their sizes in the room file")
