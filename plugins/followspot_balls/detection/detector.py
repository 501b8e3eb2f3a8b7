"""Parameters and output that the detectors of all cameras share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from followspot import Array, Field, Mistake, StageParams
from followspot.geometry import undistort
from followspot.room import Camera, Room, Target
from followspot.tracking import Blobs
from followspot_balls.detection.hue import BINS
from followspot_balls.detection.rival_colors import TOLD_APART
from followspot_balls.scene.targets import unchanging


class SearchParams(StageParams):
    """How far from the forecast a target is searched for in a picture."""

    minimum_search_radius: float = Field(
        10.0,
        gt=0,
        unit="px",
        description="smallest search radius in a picture of 320 pixels across; it grows in proportion in "
        "larger ones; raising it survives jumps and costs time",
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


def without_template(
    room: Room, cameras: Sequence[Camera], kind: str, template: Callable[[Target], Mapping[str, Any]]
) -> Iterator[Mistake]:
    """The targets that no camera can find, for lack of a template. kind: of the cameras, for people."""
    if not room.targets:
        yield Mistake(None, f'the room "{room.name}" has no targets to find', "followspot calibrate targets")
    for target in room.targets.values():
        if not any(c.name in template(target) and c.name in target.area for c in cameras):
            names = ", ".join(camera.name for camera in cameras)
            text = f'target "{target.name}" has no template in any {kind} camera ({names}), so none finds it'
            yield Mistake(None, text, "followspot calibrate targets --room ROOM.yaml --clips CLIPS learns it")


def of_one_color(room: Room, cameras: Sequence[Camera]) -> Iterator[Mistake]:
    """The targets that no camera tells from another one, each with the first such."""
    targets = list(room.targets.values())
    hues = [[t.hue_histogram.get(c.name, np.zeros(BINS)) for c in cameras] for t in targets]
    roots = np.sqrt(np.array(hues).reshape(len(targets), len(cameras), BINS))
    known = np.asarray(roots.any(axis=2))
    both = known[:, None] & known  # (T, T, C)
    apart = both & (np.einsum("acb,dcb->adc", roots, roots) < TOLD_APART)
    alike = np.tril(both.any(axis=2) & ~apart.any(axis=2), -1)
    for row in np.flatnonzero(alike.any(axis=1)):
        first, other = targets[row].name, targets[alike[row].argmax()].name
        text = f'target "{first}" has the colour of "{other}" in all cameras, so one is taken for the other'
        yield Mistake(None, text, "give each target a colour of its own, and learn its template again")


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
    # What is read-only is sent as it is, a part of a column that can be changed as a copy.
    pixel, area, similarity, targets = (unchanging(column.take(rows, axis=0)) for column in found)
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
