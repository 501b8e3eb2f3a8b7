"""Parameters and output that the detectors of all cameras share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot import Array, Field, StageParams
from followspot.geometry import undistort
from followspot.room import Camera
from followspot.tracking import Blobs


class SearchParams(StageParams):
    """How far from the forecast a target is searched for in a picture."""

    minimum_search_radius: float = Field(
        10.0, gt=0, unit="px", description="smallest search radius; raising it survives jumps and costs time"
    )
    search_radius_scale: float = Field(
        1.5, gt=0, unit="1", description="search radius over the expected travel; raising it survives turns"
    )


class DetectionParams(SearchParams):
    """Parameters of both detectors."""

    minimum_area: float = Field(
        0.3,
        gt=0,
        unit="1",
        description="smallest blob area over the template's; raising it rejects more",
    )
    maximum_area: float = Field(
        1.5,
        gt=0,
        unit="1",
        description="largest blob area over the template's; raising it accepts more",
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
