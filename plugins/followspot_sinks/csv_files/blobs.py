"""Detections in pictures as a CSV file."""

from __future__ import annotations

import numpy as np

from followspot import Field, Joined, OutputPath, StageParams
from followspot.tracking import Blobs
from followspot_sinks.line_sink import LineSink, seconds


class CsvBlobs(LineSink):
    """Write one row per blob and target that it may belong to: px in the picture as it was taken."""

    head = "frame,time,camera,target,u,v,area,similarity\n"

    class Params(StageParams):
        path: OutputPath = Field("blobs.csv", description="the CSV file, below the output folder")

    params: Params

    def setup(self) -> None:
        """Create the file. Raises FollowspotError if that is not possible."""
        super().setup()
        self.names = tuple(self.room.targets)

    def process(self, blobs: Joined[Blobs]) -> None:
        """Add the rows of one frame, camera after camera."""
        for one in blobs:
            start = f"{one.header.seq},{seconds(one.header.time)},{one.camera}"
            values = np.column_stack([one.pixel, one.area, one.similarity]).tolist()
            for row, target in np.argwhere(one.targets).tolist():
                u, v, area, similarity = values[row]
                self.write([f"{start},{self.names[target]},{u:.3f},{v:.3f},{area:.0f},{similarity:.4f}\n"])
