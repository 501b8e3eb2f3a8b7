"""Points in pictures that another program found."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from followspot import Mistake, Room, Source, Stage, at
from followspot.csv_rows import FIRST_LINE, FIRST_ROWS, Row
from followspot.errors import Place
from followspot.points import Points2D
from followspot.room import Member
from followspot_vision.frame_table import FrameParams, FrameTable, read_frames
from followspot_vision.picture_points import (
    Found,
    PictureParams,
    coordinate,
    label_of,
    points_of,
    score_of,
    shares_as_pixels,
)


class PointsCsv(Stage):
    """Points from a CSV file: frame or time, camera, x, y, and if there are any label, score and instance.

    Rows of each camera are sorted by frame; a frame in which a camera saw nothing has no row and gives an
    empty message. A label that is the name of a target of the room means that target.
    """

    per_camera = True

    class Params(FrameParams, PictureParams):
        """The file, its times and its frame of reference."""

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Read the first rows. Raises InputError. Warn if they are in another unit."""
        found = _read(params, member.name if member is not None else None, room, FIRST_ROWS)
        places = np.array([(one.x, one.y) for frame in found.own for one in frame.rows])
        return shares_as_pixels(places, params, Place(str(params.path), FIRST_LINE, 1))

    def setup(self) -> None:
        """Read the file whole. Raises InputError with file, line and remedy."""
        self.frames = _read(self.params, self.camera.name, self.room)
        if not self.frames.own:
            self.context.warn(f"{self.params.path} has no points of camera {self.camera.name}")
        if doubt := self.frames.doubt:
            self.context.warn(f"{self.params.path}: {doubt}")

    def length(self) -> int:
        """Number of frames."""
        return len(self.frames)

    def process(self) -> Source[Points2D]:
        """One message for each frame of the file."""
        for frame in self.frames:
            yield at(frame.time, points_of(frame.rows, self.camera, self.params), seq=frame.number)


def _read(
    given: PointsCsv.Params, camera: str | None, room: Room, most: int | None = None
) -> FrameTable[Found]:
    names = ("label", "score", "instance")
    return read_frames(given, ("x", "y"), names, lambda row: _point(row, given), camera, room.cameras, most)


def _point(row: Row, given: PictureParams) -> Found:
    instance = row.integer("instance") if row.has("instance") else -1
    x, y = (coordinate(row, column, given) for column in ("x", "y"))
    return Found(x, y, label_of(row), instance, score_of(row))
