"""Corners of the board in all cameras, moment by moment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from followspot import Camera
from followspot_calibrate.boards.detection import View
from followspot_calibrate.sightings import Sightings

MOST_LABELS = 100_000
"""More than any board has corners."""


def sightings_of(cameras: Sequence[Camera], views: Mapping[str, Sequence[View]]) -> Sightings:
    """A row for each corner and moment that a camera saw, in the order of moments and corners.

    views: camera -> its views, where frame is the number of the moment.
    """
    keys = [
        np.concatenate(
            [np.empty(0, np.int64), *(v.frame * MOST_LABELS + v.label for v in views[camera.name])]
        )
        for camera in cameras
    ]
    rows = np.unique(np.concatenate(keys))
    pixel = np.full((len(rows), len(cameras), 2), np.nan)
    for number, camera in enumerate(cameras):
        if len(keys[number]):
            places = np.searchsorted(rows, keys[number])
            pixel[places, number] = np.concatenate([view.pixel for view in views[camera.name]])
    return Sightings(
        tuple(camera.name for camera in cameras),
        np.array([camera.size for camera in cameras], float),
        rows // MOST_LABELS,
        rows % MOST_LABELS,
        pixel,
    )
