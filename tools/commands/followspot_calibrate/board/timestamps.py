"""Which pictures of different cameras belong to one moment, after caliscope's timestamps.csv."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from followspot_cameras.recorded_times.table import read_table

Moments = Mapping[str, Mapping[int, int]]
"""Camera -> number of a picture in its recording -> number of the moment."""


def read_timestamps(path: Path, cameras: Sequence[str]) -> Moments:
    """Moments of the pictures of each camera; a moment is a sync_index of the table. Raises InputError."""
    found: dict[str, dict[int, int]] = {}
    for camera in cameras:
        pictures = enumerate(read_table(path, camera, ("sync_index",)))
        found[camera] = {k: picture.moment for k, picture in pictures if picture.moment is not None}
    return found
