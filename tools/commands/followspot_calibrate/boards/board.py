"""Boards as users name them: charuco:4x5:0.054:DICT_4X4_50, chessboard:9x6:0.025, aruco:0.2:DICT_4X4_50:7."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from followspot.errors import InputError, did_you_mean
from followspot.messages import Array

USUAL_MARKER = 0.75
"""Default side of a marker over that of its square."""
MOST_SQUARES = 50
FLAGS = ["inverted", "legacy"]
FORM = (
    "charuco:COLUMNSxROWS:SQUARE[/MARKER]:DICTIONARY[:inverted][:legacy] (squares), "
    "chessboard:COLUMNSxROWS:SQUARE (inner corners) or "
    "aruco:SIDE:DICTIONARY:ID[:inverted] (a single marker); lengths in m"
)
_GRID = re.compile(r"(\d{1,3})x(\d{1,3})")


@dataclass(frozen=True)
class Board:
    """A printed pattern of squares, or a single marker.

    columns, rows: of squares (ChArUco) or of corners (chessboard: inner ones), as each is commonly named;
    square, marker: sides, m; dictionary: name of the ArUco dictionary; inverted: printed white on black;
    legacy: ChArUco as OpenCV before 4.6 drew it; number: of the single marker.
    """

    pattern: Literal["charuco", "chessboard", "aruco"]
    columns: int
    rows: int
    square: float
    marker: float = 0.0
    dictionary: str = ""
    inverted: bool = False
    legacy: bool = False
    number: int = 0

    @property
    def inner(self) -> tuple[int, int]:
        """Inner corners in a row, and rows of them."""
        less = 1 if self.pattern == "charuco" else 0
        return self.columns - less, self.rows - less

    @property
    def corners(self) -> Array:
        """Inner corners in the board's own frame, row by row: (N, 3) m, z = 0; the index is the label.

        Of a single marker they are its own four.
        """
        across, down = self.inner
        row, column = np.divmod(np.arange(across * down), across)
        return np.column_stack([column, row, np.zeros_like(row)]) * self.square

    @property
    def fewest(self) -> int:
        """Corners that a view must have: four determine a homography, two more show whether it is one."""
        return 4 if self.pattern == "aruco" else 6

    @property
    def symmetric(self) -> bool:
        """True if half a turn does not change its look, so that its corners cannot be told apart."""
        return self.pattern == "chessboard" and (self.columns + self.rows) % 2 == 0


def parse_board(text: str) -> Board:
    """The board that a text names. Raises InputError."""
    pattern, *fields = text.split(":")
    if pattern == "aruco":
        return _marker(fields, text)
    if pattern not in ("charuco", "chessboard"):
        raise _wrong(f'--board {text}: there is no pattern "{pattern}"')
    if pattern == "chessboard":
        if len(fields) != 2:
            raise _wrong(f"--board {text}: a chessboard has 2 properties, not {len(fields)}")
        columns, rows = _grid(fields[0], text, least=3)
        return Board("chessboard", columns, rows, _length(fields[1], text))
    if len(fields) < 3 or not set(fields[3:]) <= set(FLAGS):
        raise _wrong(f"--board {text}: this is no ChArUco board")
    columns, rows = _grid(fields[0], text, least=3)
    side, _, inside = fields[1].partition("/")
    square = _length(side, text)
    marker = _length(inside, text) if inside else USUAL_MARKER * square
    if marker >= square:
        raise _wrong(f"--board {text}: the marker must be smaller than its square")
    flags = fields[3:]
    return Board(
        "charuco", columns, rows, square, marker, _dictionary(fields[2]), FLAGS[0] in flags, FLAGS[1] in flags
    )


def _marker(fields: Sequence[str], text: str) -> Board:
    """A single marker. Raises InputError."""
    if len(fields) not in (3, 4) or fields[3:] not in ([], FLAGS[:1]) or not fields[2].isdecimal():
        raise _wrong(f"--board {text}: this is no single marker")
    side, name, number = _length(fields[0], text), _dictionary(fields[1]), int(fields[2])
    most = len(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name)).bytesList) - 1
    if number > most:
        raise _wrong(f"--board {text}: {name} has the markers 0 to {most}")
    return Board("aruco", 2, 2, side, side, name, inverted=bool(fields[3:]), number=number)


def _grid(text: str, whole: str, least: int) -> tuple[int, int]:
    match = _GRID.fullmatch(text)
    if match is None or not all(least <= int(size) <= MOST_SQUARES for size in match.groups()):
        raise _wrong(f"--board {whole}: {text} is no COLUMNSxROWS from {least} to {MOST_SQUARES}")
    return int(match[1]), int(match[2])


def _length(text: str, whole: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 1e-4 < value < 10:
        raise _wrong(f"--board {whole}: {text} is no length of a square in metres")
    return value


def _dictionary(name: str) -> str:
    known = [key for key in dir(cv2.aruco) if key.startswith("DICT_")]
    if name not in known:
        text = f'--board: there is no dictionary "{name}"'
        raise InputError.of(text, did_you_mean(name, known, "dictionaries"))
    return name


def _wrong(text: str) -> InputError:
    return InputError.of(text, FORM)
