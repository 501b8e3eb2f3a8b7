"""What the detectors of all cameras share: where they search, and how they say what they found."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot import Array, Field, StageParams
from followspot.geometry import undistort
from followspot.room import Camera
from followspot.tracking import Blobs


class DetectionParams(StageParams):
    """Of both detectors."""

    smallest: float = Field(
        0.3,
        gt=0,
        unit="1",
        description="smallest area over the template's; lowering it accepts balls that are mostly hidden",
    )
    radius: float = Field(
        10.0,
        gt=0,
        unit="px",
        description="smallest search radius; raising it survives jumps, and costs time",
    )
    scale: float = Field(
        1.5,
        gt=0,
        unit="1",
        description="search radius over expected travel; raising it survives sharper turns",
    )


class Detections(NamedTuple):
    """Blobs of several views; N rows, as in the columns of `Blobs`."""

    pixel: Array
    area: Array
    similarity: Array
    targets: Array


def blobs_by_view(cameras: Sequence[Camera], view: Array, found: Detections, rows: Array) -> list[Blobs]:
    """One message for each camera.

    view: (N,) number of the camera that shows each blob; rows: (M,) ascending, those that are sent.
    """
    rows = rows.take(view.take(rows).argsort(kind="stable"))
    pixel, area, similarity, targets = (column.take(rows, axis=0) for column in found)
    ends = view.take(rows).searchsorted(np.arange(len(cameras) + 1)).tolist()
    return [
        Blobs(
            camera=camera.name,
            xy=undistort(camera, pixel[first:end]),
            pixel=pixel[first:end],
            area=area[first:end],
            similarity=similarity[first:end],
            targets=targets[first:end],
        )
        for camera, first, end in zip(cameras, ends, ends[1:], strict=False)
    ]
