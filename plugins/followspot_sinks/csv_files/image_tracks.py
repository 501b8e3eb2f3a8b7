"""Tracks in pictures as a CSV file."""

from __future__ import annotations

import numpy as np

from followspot import Field, Joined, OutputPath, StageParams
from followspot.tracking import ImageTracks
from followspot_sinks.line_sink import LineSink, seconds


class CsvImageTracks(LineSink):
    """Write one row per track and frame: px in the picture as it was taken, velocity and residual without
    distortion, px/s and px.
    """

    head = "frame,time,camera,target,track,u,v,du,dv,residual\n"

    class Params(StageParams):
        path: OutputPath = Field("image_tracks.csv", description="the CSV file, below the output folder")

    params: Params

    def setup(self) -> None:
        """Create the file. Raises FollowspotError if that is not possible."""
        super().setup()
        self.names = tuple(self.room.targets)

    def process(self, tracks: Joined[ImageTracks]) -> None:
        """Add the rows of one frame, camera after camera."""
        for one in tracks:
            start = f"{one.header.seq},{seconds(one.header.time)},{one.camera}"
            values = np.column_stack([one.pixel, one.velocity, one.residual]).tolist()
            self.write(
                f"{start},{self.names[target]},{track}," + ",".join(f"{v:.3f}" for v in row) + "\n"
                for target, track, row in zip(one.target.tolist(), one.track.tolist(), values, strict=True)
            )
