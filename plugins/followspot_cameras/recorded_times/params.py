"""Parameters of sources of recordings whose pictures have capture times of their own."""

from __future__ import annotations

from pathlib import Path

from followspot import Field, InputPath, StageParams
from followspot.frame_times import to_ns
from followspot_cameras.recorded_times.table import read_table
from followspot_cameras.recorded_times.time_list import read_time_list


class TimesParams(StageParams):
    """Parameters of capture times: the file that lists them, and the time that is added to them."""

    times: InputPath | None = Field(
        None,
        description="file with the pictures' capture times: a table .csv with cam_id and frame_time (s), "
        "or a list of time stamps of format v2 (ms)",
    )
    start_time: float = Field(
        0.0,
        ge=-4e9,
        le=4e9,
        unit="s",
        description="capture time of picture 0, or of time 0 where times are recorded",
    )

    @property
    def start(self) -> int:
        """Ns"""
        return to_ns(self.start_time)


def read_times(path: Path, camera: str) -> list[int]:
    """Capture times, ns, of the pictures of a camera's recording. Raises InputError."""
    if path.suffix.lower() != ".csv":
        return read_time_list(path)
    pictures = read_table(path, camera, ("frame_time",))
    return [picture.time for picture in pictures if picture.time is not None]
