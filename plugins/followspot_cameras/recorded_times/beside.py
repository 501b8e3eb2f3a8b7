"""Files with capture times that lie beside recordings."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from followspot.csv_rows import header_of
from followspot_cameras.recorded_times.table import read_table

TABLE = "timestamps.csv"
LIST = ".pts"


def times_beside(camera: str, recording: Path) -> Path | None:
    """The file with the capture times of a camera's recording: its own list, or the table of all cameras.

    None if there is neither, or the table has no times. Raises InputError for a table that
    cannot be read.
    """
    own, table = recording.with_suffix(LIST), recording.parent / TABLE
    if own.is_file():
        return own
    if table.is_file() and {"cam_id", "frame_time"} <= set(header_of(table)):
        return table
    return None


def spread_of_moments(table: Path, cameras: Iterable[str]) -> int:
    """The longest time between two pictures of one moment, ns; 0 if the table tells no moments.

    cameras: whose pictures count. Raises InputError.
    """
    if "sync_index" not in header_of(table):
        return 0
    moments: dict[int, list[int]] = {}
    for camera in cameras:
        for picture in read_table(table, camera, ("sync_index", "frame_time")):
            if picture.moment is not None and picture.time is not None:
                moments.setdefault(picture.moment, []).append(picture.time)
    return max((max(times) - min(times) for times in moments.values()), default=0)
