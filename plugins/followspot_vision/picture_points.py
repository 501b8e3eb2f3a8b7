"""Positions in a picture, in the units of other programs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from followspot import Camera, Field, StageParams
from followspot.csv_rows import Row
from followspot.errors import Mistake, Place
from followspot.geometry import distort, undistort
from followspot.messages import Array
from followspot.points import Points2D

FARTHEST = 1e6
"""Largest coordinate, px."""
FARTHEST_SHARE = 10.0
"""Largest share of the width or height: places beside a picture have shares beyond 0 to 1."""
NEAR_SHARES = (-0.5, 1.5)
"""Places that all lie between these are no pixels."""


class PictureParams(StageParams):
    """The frame of reference of points in a picture."""

    unit: Literal["px", "share"] = Field(
        "px",
        description="px, or shares of width and height, 0 to 1 from the left upper corner",
    )
    pixel_origin: Literal["center", "corner"] = Field(
        "center",
        description="where 0 px is: at the centre of the first pixel, as in OpenCV, or at its corner",
    )
    undistorted: bool = Field(
        False, description="whether the lens distortion was removed before the points were found"
    )
    minimum_score: float | None = Field(
        None, unit="1", description="score below which points are left out; raising it avoids mistakes"
    )


@dataclass(frozen=True)
class Found:
    """A point in a picture, in the file's unit."""

    x: float
    y: float
    label: str
    instance: int
    score: float


def coordinate(row: Row, column: str, given: PictureParams) -> float:
    """A number that can be a place in a picture. Raises InputError."""
    value = row.number(column)
    if wrong := wrong_unit(value, given):
        raise row.mistake(column, wrong)
    return value


def wrong_unit(value: float, given: PictureParams) -> str:
    """The range that this coordinate in the given unit lies outside of, as text; "" if inside."""
    if given.unit == "share" and abs(value) > FARTHEST_SHARE:
        return "a share of the width or height, 0 to 1; places in px need with: {unit: px}"
    return f"a place in the picture, within {FARTHEST:.0f} px" if abs(value) > FARTHEST else ""


def shares_as_pixels(places: Array, given: PictureParams, file: Place | None) -> Iterator[Mistake]:
    """A warning if the parameters say px, and all places can only be shares.

    places: (N, 2), or (N, 4) corners of boxes; file: the place of the warning, None for the parameter's.
    """
    low, high = NEAR_SHARES
    if given.unit == "px" and len(places) and ((places > low) & (places < high)).all() and (places % 1).any():
        text = "all places lie within two pixels of the corner of the picture: they are shares of its size"
        yield Mistake(file, text, "with: {unit: share}", warning=True)


def label_of(row: Row) -> str:
    """The label, "" if there is none. Raises InputError if it is too long."""
    return row.text("label") if row.has("label") and row.cell("label") else ""


def score_of(row: Row) -> float:
    """The score, 1 if there is none. Raises InputError."""
    return row.number("score") if row.has("score") else 1.0


def counts(score: float, given: PictureParams) -> bool:
    """Whether a point with this score is kept."""
    return given.minimum_score is None or score >= given.minimum_score


def in_pixels(xy: Array, camera: Camera, given: PictureParams) -> Array:
    """(N, 2) in the file's unit -> (N, 2) px, 0 at the centre of the first pixel."""
    if given.unit == "share":
        return np.asarray(xy * np.array(camera.size) - 0.5)
    return xy - 0.5 if given.pixel_origin == "corner" else xy


def points_of(found: Sequence[Found], camera: Camera, given: PictureParams) -> Points2D:
    """The message of one picture; points with too low a score are left out."""
    found = [one for one in found if counts(one.score, given)]
    labels = tuple(dict.fromkeys(one.label for one in found))
    number = {label: i for i, label in enumerate(labels)}
    there = in_pixels(np.array([(one.x, one.y) for one in found], "f8").reshape(-1, 2), camera, given)
    return Points2D(
        camera=camera.name,
        labels=labels,
        label=np.array([number[one.label] for one in found], "i4"),
        instance=np.array([one.instance for one in found], "i4"),
        pixel=distort(camera, there) if given.undistorted else there,
        xy=there if given.undistorted else undistort(camera, there),
        score=np.array([one.score for one in found], "f8"),
    )
