"""Pictures of upper bodies with their pose, as a folder of crops and a table `boxes.csv`."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot import Array
from followspot.errors import InputError
from followspot.files import open_text
from followspot_cameras.images import read_picture

COLUMNS = ("file", "body", "torso_heading", "head_pan", "head_tilt", "y0", "y1", "neck_u")
MAX_CROPS = 20_000
LARGEST = 1e6


@dataclass(frozen=True, eq=False)
class Crops:
    """N pictures of one size.

    pixels: (N, H, W, 3) u1 BGR; body: (N,) number of the person; torso, head: (N,) rad, heading of chest and
    face relative to the camera; tilt: (N,) rad; axis, top: (N,) px, column of the body's axis and row of the
    head's top; bottom: (N,) px, row of the waist.
    """

    pixels: Array
    body: Array
    torso: Array
    head: Array
    tilt: Array
    axis: Array
    top: Array
    bottom: Array


def read_crops(folder: Path) -> Crops:
    """The crops in a folder. Raises InputError if the table or a picture is missing or wrong."""
    table = folder / "boxes.csv"
    try:
        with open_text(table) as file:
            rows = [row for row, _ in zip(csv.DictReader(file), range(MAX_CROPS), strict=False)]
        columns = {name: [row[name] for row in rows] for name in COLUMNS}
        numbers = {name: np.array(columns[name], float) for name in COLUMNS[1:]}
        if not rows or not all((np.abs(n) <= LARGEST).all() for n in numbers.values()):
            raise ValueError(f"no rows, or a number that is not finite or beyond {LARGEST:.0f}")
    except KeyError as error:
        raise _mistake(table, f"has no column {error}") from None
    except (OSError, ValueError, TypeError, csv.Error) as error:
        raise _mistake(table, str(error)) from None
    return Crops(
        pixels=_pictures(folder, columns["file"]),
        body=numbers["body"].astype(int),
        torso=numbers["torso_heading"],
        head=numbers["torso_heading"] + numbers["head_pan"],
        tilt=numbers["head_tilt"],
        axis=numbers["neck_u"],
        top=numbers["y0"],
        bottom=numbers["y1"],
    )


def _pictures(folder: Path, names: list[str]) -> Array:
    pictures: list[Array] = []
    for name in names:
        if Path(name).name != name:
            raise _mistake(folder / "boxes.csv", f'"{name}" is not the name of a file beside it')
        picture = read_picture(folder / name)
        if picture is None or (pictures and picture.shape != pictures[0].shape):
            raise _mistake(folder / name, "no picture, or not as large as the others")
        pictures.append(np.asarray(picture))
    return np.array(pictures)


def _mistake(path: Path, text: str) -> InputError:
    remedy = f"the folder needs pictures of one size and boxes.csv with the columns {', '.join(COLUMNS)}"
    return InputError.of(f"{path}: {text}", remedy)
