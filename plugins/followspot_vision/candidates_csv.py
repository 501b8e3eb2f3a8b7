"""Points in the room that another program found."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np
from pydantic import field_validator

from followspot import Field, Mistake, Room, Source, Stage, at
from followspot.csv_rows import FIRST_ROWS, Row
from followspot.points import Points3D
from followspot.room import Member
from followspot.rotation import signed_axes
from followspot_vision.frame_table import FrameParams, FrameRows, FrameTable, read_frames
from followspot_vision.picture_points import label_of, score_of

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
FARTHEST = 1e5
"""Largest coordinate, m."""
Point = tuple[float, float, float, float, str, float]
"""x, y, z and sigma in the file's unit, label, score."""


class CandidatesCsv(Stage):
    """Points from a CSV file: frame or time, x, y, z, and if there are any label, score and sigma (one
    standard deviation along each axis).

    A label that is the name of a target of the room means that target.
    """

    class Params(FrameParams):
        """The file, its times and its frame of reference."""

        unit: Literal["m", "cm", "mm", "in", "ft"] = Field("m", description="unit of x, y, z and sigma")
        axes: str = Field(
            "x y z",
            pattern=r"^-?[xyz] -?[xyz] -?[xyz]$",
            description="axes of the file that are the room's x, y and z (up): x -z y if y is up in the file",
        )
        origin: tuple[float, float, float] = Field(
            (0.0, 0.0, 0.0), unit="m", description="place in the room of the file's origin"
        )
        sigma: float | None = Field(
            None,
            gt=0,
            unit="m",
            description="one sigma of points without a column sigma; by default it is not known",
        )
        minimum_score: float | None = Field(
            None, unit="1", description="score below which points are left out; raising it avoids mistakes"
        )

        @field_validator("axes")
        @classmethod
        def _check_axes(cls, value: str) -> str:
            signed_axes(value)
            return value

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Read the first rows. Raises InputError."""
        _read(params, METRES[params.unit], FIRST_ROWS)
        return ()

    def setup(self) -> None:
        """Read the file whole. Raises InputError with file, line and remedy."""
        scale = METRES[self.params.unit]
        self.axes = scale * signed_axes(self.params.axes)
        self.frames = _read(self.params, scale)

    def length(self) -> int:
        """Number of frames."""
        return len(self.frames)

    def process(self) -> Source[Points3D]:
        """One message for each frame of the file."""
        for frame in self.frames:
            yield at(frame.time, self.points(frame), seq=frame.number)

    def points(self, frame: FrameRows[Point]) -> Points3D:
        """The points of one frame, in the room."""
        least = self.params.minimum_score
        rows = [row for row in frame.rows if least is None or row[5] >= least]
        labels = tuple(dict.fromkeys(row[4] for row in rows))
        numbers = np.array([row[:4] for row in rows], "f8").reshape(-1, 4)
        sigma = numbers[:, 3] * METRES[self.params.unit]
        sigma[np.isnan(sigma)] = np.nan if self.params.sigma is None else self.params.sigma
        return Points3D(
            labels=labels,
            label=np.array([labels.index(row[4]) for row in rows], "i4"),
            xyz=numbers[:, :3] @ self.axes.T + np.array(self.params.origin),
            covariance=np.square(sigma)[:, None, None] * np.eye(3),
            views=np.zeros(len(rows), "i4"),
            error=np.full(len(rows), np.nan),
            score=np.array([row[5] for row in rows], "f8"),
        )


def _read(given: FrameParams, scale: float, most: int | None = None) -> FrameTable[Point]:
    names = ("label", "score", "sigma")
    return read_frames(given, ("x", "y", "z"), names, lambda row: _point(row, scale), most=most)


def _point(row: Row, scale: float) -> Point:
    x, y, z = row.numbers("x", "y", "z")
    for column, value in zip("xyz", (x, y, z), strict=True):
        if abs(value) * scale > FARTHEST:
            raise row.mistake(column, f"a place within {FARTHEST:.0f} m")
    sigma = row.number("sigma") if row.has("sigma") else np.nan
    if sigma <= 0:
        raise row.mistake("sigma", "a standard deviation above 0")
    return x, y, z, sigma, label_of(row), score_of(row)
