"""The pictures that detectors learn from: upper bodies with their headings, and places without people.

Two forms of folder are known. One holds `boxes.csv` (file, body, room, torso_heading, head_pan) with crops
that have the upper body always in the same place, and `neg_ROOM...` pictures; the other `pos/`, crops of
96 x 160 px with a whole person in the middle, as the INRIA Person data set has them, and `neg/`.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot import Array
from followspot.errors import InputError
from followspot.files import PICTURE, open_text
from followspot_cameras.images import read_picture

MIDDLE = (48.0, 22.0)
"""Column of the body's axis and row of the head's top in a crop of `boxes.csv`, px."""
UPPER = 72.0
"""Height of the upper body in it, px."""
PEDESTRIAN = np.array([28.0, 30.0, 68.0, 74.0])
"""Box of the upper body in a crop of the INRIA form, px."""
PLACES = 4
"""Parts into which pictures of the INRIA form are divided, each a place of its own."""
MOST = 20_000
"""Pictures of one folder."""


@dataclass(frozen=True, eq=False)
class Person:
    """An upper body in a picture. Headings are relative to the camera, rad, NaN if unknown."""

    pixels: Array
    box: Array
    """(4,) x0, y0, x1, y1, px."""
    body: int
    """Number of the person, -1 if every crop shows another person."""
    place: str
    torso: float = float("nan")
    head: float = float("nan")
    folder: str = ""
    """The folder that the picture is from, as it was given."""


@dataclass(frozen=True, eq=False)
class Background:
    """A picture without people."""

    pixels: Array
    place: str
    folder: str = ""


@dataclass(frozen=True)
class Pictures:
    """The pictures of one or more folders."""

    persons: tuple[Person, ...] = ()
    backgrounds: tuple[Background, ...] = ()

    def __add__(self, other: Pictures) -> Pictures:
        return Pictures(self.persons + other.persons, self.backgrounds + other.backgrounds)


def read_folder(folder: Path) -> Pictures:
    """Read a folder of either form. Raises InputError if it has neither, or if a picture cannot be read."""
    if (folder / "boxes.csv").is_file():
        return _with_boxes(folder)
    if (folder / "pos").is_dir() and (folder / "neg").is_dir():
        return _pedestrians(folder)
    remedy = "give a folder with boxes.csv and its crops, or one with pos/ and neg/"
    raise _mistake(f"{folder} holds no pictures to learn from", remedy)


def _with_boxes(folder: Path) -> Pictures:
    persons = []
    with open_text(folder / "boxes.csv") as stream:
        for line, row in enumerate(csv.DictReader(stream), start=2):
            try:
                persons.append(_person(folder, row))
            except (KeyError, TypeError, ValueError) as error:
                text = f"{folder / 'boxes.csv'}, line {line}: {error!r}"
                raise _mistake(text, "columns: file, body, room, torso_heading, head_pan, ...") from None
    rooms = sorted({person.place for person in persons})
    backgrounds = [
        Background(_picture(file), room, str(folder))
        for room in rooms
        for file in sorted(folder.glob(f"neg_{room}*"))
    ]
    return Pictures(tuple(persons), tuple(backgrounds))


def _person(folder: Path, row: dict[str, str]) -> Person:
    """The crops are cut around the body, so that its box in them is the same for all."""
    name, torso = row["file"], float(row["torso_heading"])
    if Path(name).name != name:
        raise ValueError(f"{name} is no name of a file in this folder")
    across, top = MIDDLE
    box = np.array([across - UPPER / 3, top, across + UPPER / 3, top + UPPER])
    pixels = _picture(folder / name)
    head = torso + float(row["head_pan"])
    return Person(pixels, box, int(row["body"]), row["room"], torso, head, str(folder))


def _pedestrians(folder: Path) -> Pictures:
    positive, negative = _files(folder / "pos"), _files(folder / "neg")
    persons = [
        Person(_picture(file), PEDESTRIAN, -1, f"street{PLACES * i // len(positive)}", folder=str(folder))
        for i, file in enumerate(positive)
    ]
    backgrounds = [
        Background(_picture(file), f"street{PLACES * i // len(negative)}", str(folder))
        for i, file in enumerate(negative)
    ]
    return Pictures(tuple(persons), tuple(backgrounds))


def _files(folder: Path) -> list[Path]:
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in (".jpg", ".png"))
    if len(files) > MOST:
        raise _mistake(f"{folder} holds {len(files)} pictures", f"give at most {MOST}")
    return files


def _picture(file: Path) -> Array:
    """(H, W, 3) u8, BGR. Raises InputError."""
    pixels = read_picture(file)
    if pixels is None:
        raise _mistake(f"{file} is no picture of at most {PICTURE} bytes", "give .jpg or .png files")
    return np.asarray(pixels)


def _mistake(text: str, remedy: str) -> InputError:
    return InputError.of(text, remedy)
