"""The pictures that detectors learn from: upper bodies with their headings, and places without people.

Two forms of folder are known. One holds `boxes.csv` (file, body, room, torso_heading, head_pan) with crops
that have the upper body always in the same place, and `neg_ROOM...` pictures; the other `pos/`, crops of
96 x 160 px with a whole person in the middle, as the INRIA Person data set has them, and `neg/`.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Collection
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
REMEDY = "columns: file, body, room, torso_heading, head_pan, ..."
_ROOM = re.compile(r"[\w-]+")
_TURNS, _BODIES = 100.0, 2**31 - 1
"""Largest angle, rad, and largest number of a body in `boxes.csv`."""
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
    table = folder / "boxes.csv"
    persons = []
    try:
        with open_text(table) as stream:
            for line, row in enumerate(csv.DictReader(stream), start=2):
                persons.append(_row(folder, row, f"{table}, line {line}"))
    except (OSError, UnicodeError, csv.Error) as error:
        raise _mistake(f"{table} cannot be read: {error}", REMEDY) from None
    return Pictures(tuple(persons), _backgrounds(folder, {person.place for person in persons}))


def _row(folder: Path, row: dict[str, str], where: str) -> Person:
    try:
        return _person(folder, row)
    except (KeyError, TypeError, ValueError) as error:
        raise _mistake(f"{where}: {error!r}", REMEDY) from None


def _backgrounds(folder: Path, rooms: Collection[str]) -> tuple[Background, ...]:
    """The pictures neg_ROOM...; of rooms whose names begin alike, each is of the longest that it names."""
    found = []
    for file in folder.glob("neg_*"):
        rooms_of_it = [room for room in rooms if file.name.startswith(f"neg_{room}")]
        found += [(max(rooms_of_it, key=len), file)] if rooms_of_it else []
    return tuple(Background(_picture(file), room, str(folder)) for room, file in sorted(found))


def _person(folder: Path, row: dict[str, str]) -> Person:
    """The crops are cut around the body, so that its box in them is the same for all."""
    name, room = row["file"], row["room"]
    torso, pan, body = float(row["torso_heading"]), float(row["head_pan"]), int(row["body"])
    if Path(name).name != name:
        raise ValueError(f"{name} is no name of a file in this folder")
    if not _ROOM.fullmatch(room):
        raise ValueError(f"{room!r} is no name of a room: letters, digits, _ and -")
    if abs(torso) > _TURNS or abs(pan) > _TURNS or not -1 <= body <= _BODIES:
        raise ValueError("headings are rad, nan if unknown, and bodies are numbered from 0, -1 if unknown")
    across, top = MIDDLE
    box = np.array([across - UPPER / 3, top, across + UPPER / 3, top + UPPER])
    pixels = _picture(folder / name)
    if (pixels.shape[:2] < box[:1:-1]).any():
        raise ValueError(f"{name} is no crop of at least {box[2]:.0f} x {box[3]:.0f} px")
    return Person(pixels, box, body, room, torso, torso + pan, str(folder))


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
