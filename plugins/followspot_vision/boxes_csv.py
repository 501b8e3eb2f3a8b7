"""Boxes in pictures that another program found."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from followspot import Field, Mistake, Room, Source, Stage, at
from followspot.csv_rows import FIRST_LINE, FIRST_ROWS, Row
from followspot.errors import Place
from followspot.people import Boxes
from followspot.points import Points2D
from followspot.room import Member
from followspot_vision.frame_table import FrameParams, FrameRows, FrameTable, read_frames
from followspot_vision.picture_points import (
    Found,
    PictureParams,
    coordinate,
    counts,
    in_pixels,
    label_of,
    points_of,
    score_of,
    shares_as_pixels,
)

MANY = 20
"""Boxes of a camera that tell whether its columns are right."""
BEYOND = 1.1
"""Share of the width and the height beyond which a box ends far outside the picture."""


@dataclass(frozen=True)
class Outputs:
    """The boxes, and their centres as points with the boxes' labels."""

    boxes: Boxes
    centers: Points2D


@dataclass(frozen=True)
class Box:
    """Left upper and right lower corner, in the file's unit."""

    corners: tuple[float, float, float, float]
    label: str
    score: float


class BoxesCsv(Stage):
    """Boxes from a CSV file: frame or time, camera, the four columns that `box` names, and if there are any
    label and score.

    `boxes` are upper bodies for the stages of persons: set `person_label` and `upper_share`; `centers` are
    points for `vision.triangulate`. Rows of each camera are sorted by frame.
    """

    per_camera = True

    class Params(FrameParams, PictureParams):
        """The file, its times and its frame of reference."""

        box: Literal["x0 y0 x1 y1", "x y width height", "center_x center_y width height"] = Field(
            "x0 y0 x1 y1", description="columns of a box: its corners, or a corner or the centre and its size"
        )
        person_label: str | None = Field(
            None, description="label of the boxes that are persons, for the output boxes; by default all"
        )
        upper_share: float = Field(
            1.0,
            gt=0,
            le=1,
            unit="1",
            description="share of a box, from its top, that is the upper body: 0.5 for boxes of whole bodies",
        )

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Read the first rows. Raises InputError. Warn if they are in another unit."""
        found = _read(params, member.name if member is not None else None, room, FIRST_ROWS)
        corners = np.array([box.corners for frame in found.own for box in frame.rows])
        return shares_as_pixels(corners, params, Place(str(params.path), FIRST_LINE, 1))

    def setup(self) -> None:
        """Read the file whole. Raises InputError with file, line and remedy."""
        self.frames = _read(self.params, self.camera.name, self.room)
        if not self.frames.own:
            self.context.warn(f"{self.params.path} has no boxes of camera {self.camera.name}")
        if doubt := self.frames.doubt:
            self.context.warn(f"{self.params.path}: {doubt}")
        if doubt := self.doubt_of_corners():
            self.context.warn(f"{self.params.path}: {doubt}")

    def doubt_of_corners(self) -> str:
        """Why the columns hardly fit `box`; empty if they may fit."""
        corners = np.array([b.corners[2:] for f in self.frames.own for b in f.rows], "f8").reshape(-1, 2)
        corners = in_pixels(corners, self.camera, self.params)
        beyond = int(np.count_nonzero((corners > BEYOND * np.array(self.camera.size)).any(axis=1)))
        if len(corners) < MANY or 2 * beyond < len(corners):
            return ""
        return (
            f"{beyond} of {len(corners)} boxes of camera {self.camera.name} end far beyond the picture: does "
            f'"{self.params.box}" name what the columns are, and has the room the size of the pictures?'
        )

    def length(self) -> int:
        """Number of frames."""
        return len(self.frames)

    def process(self) -> Source[Outputs]:
        """One message for each frame of the file."""
        for frame in self.frames:
            centers = [_center(box) for box in frame.rows]
            points = points_of(centers, self.camera, self.params)
            yield Outputs(
                at(frame.time, self.boxes(frame), seq=frame.number), at(frame.time, points, seq=frame.number)
            )

    def boxes(self, frame: FrameRows[Box]) -> Boxes:
        """The boxes of persons, cut to the upper body."""
        wanted = self.params.person_label
        found = [b for b in frame.rows if counts(b.score, self.params) and wanted in (None, b.label)]
        corners = np.array([b.corners for b in found], "f8").reshape(-1, 2, 2)
        box = in_pixels(corners.reshape(-1, 2), self.camera, self.params).reshape(-1, 4)
        box[:, 3] = box[:, 1] + self.params.upper_share * (box[:, 3] - box[:, 1])
        none = np.zeros((len(found), 0))
        return Boxes(self.camera.name, box, np.array([b.score for b in found], "f8"), none, none)


def _read(given: BoxesCsv.Params, camera: str | None, room: Room, most: int | None = None) -> FrameTable[Box]:
    columns = tuple(given.box.split())
    names = ("label", "score")
    return read_frames(
        given, columns, names, lambda row: _box(row, columns, given), camera, room.cameras, most
    )


def _box(row: Row, columns: tuple[str, ...], given: PictureParams) -> Box:
    a, b, c, d = (coordinate(row, column, given) for column in columns)
    if columns[2] == "width":
        a, b = (a - c / 2, b - d / 2) if columns[0] == "center_x" else (a, b)
        c, d = a + c, b + d
    if c <= a or d <= b:
        raise row.mistake(columns[2] if c <= a else columns[3], "a box with a width and a height")
    return Box((a, b, c, d), label_of(row), score_of(row))


def _center(box: Box) -> Found:
    x0, y0, x1, y1 = box.corners
    return Found((x0 + x1) / 2, (y0 + y1) / 2, box.label, -1, box.score)
