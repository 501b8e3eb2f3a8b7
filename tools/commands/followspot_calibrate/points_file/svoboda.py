"""Points as the toolbox of Svoboda, Martinec & Pajdla 2005 keeps them: points.dat, IdMat.dat, Res.dat."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.errors import InputError
from followspot.files import open_text
from followspot.messages import Array
from followspot_calibrate.points_file.naming import names_of
from followspot_calibrate.sightings import Sightings


def read_svoboda(folder: Path, cameras: Sequence[Camera]) -> Sightings:
    """points.dat: 3 rows u v 1 per camera, a column per frame; IdMat.dat: 1 if seen; Res.dat: sizes.

    Without IdMat.dat a point with finite numbers was seen. Raises InputError with the file.
    """
    points, sizes = _matrix(folder / "points.dat"), _matrix(folder / "Res.dat")
    count = len(points) // 3
    if len(points) % 3 or not count:
        raise _mistake(folder / "points.dat", f"{len(points)} rows", "three rows, u v 1, per camera")
    if sizes.shape != (count, 2) or not ((sizes >= 1) & (sizes % 1 == 0)).all():
        raise _mistake(folder / "Res.dat", f"{len(sizes)} rows", f"width and height of {count} cameras, px")
    pixel = points.reshape(count, 3, -1)[:, :2].transpose(2, 0, 1).copy()
    if (folder / "IdMat.dat").exists():
        seen = _matrix(folder / "IdMat.dat")
        if seen.shape != (count, len(pixel)):
            text = f"{seen.shape[0]} rows and {seen.shape[1]} columns"
            raise _mistake(folder / "IdMat.dat", text, f"{count} rows and {len(pixel)} columns as points.dat")
        pixel[seen.T <= 0] = np.nan
    pixel[~np.isfinite(pixel).all(axis=2)] = np.nan
    frames = np.arange(len(pixel))
    names = names_of(folder, count, cameras)
    return Sightings(names, sizes.astype(int), frames, np.zeros_like(frames), pixel)


def _matrix(path: Path) -> Array:
    """The numbers in a text file, one row a line."""
    try:
        with open_text(path) as file:
            return np.loadtxt(file, ndmin=2)
    except OSError as error:
        raise InputError.of(f"{path} cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise _mistake(path, str(error).split(";")[0], "rows of numbers of one length") from None


def _mistake(path: Path, found: str, wanted: str) -> InputError:
    return InputError.of(f"{path}: {found}", f"needs {wanted}")
