"""Tracks as a CSV file."""

from __future__ import annotations

import numpy as np

from followspot import Field, OutputPath, StageParams
from followspot.tracking import STATES, Tracks
from followspot_sinks.line_sink import LineSink, seconds

ROW = "%s,%s,%s" + ",%.6f" * 9 + "\n"


class CsvTracks(LineSink):
    """Write one row per target and frame while its position is known: s, m, m/s and one sigma in m.

    Six decimals: a micrometre is far below any error, and equal runs give equal bytes.
    """

    head = "frame,time,object,state,x,y,z,vx,vy,vz,sx,sy,sz\n"

    class Params(StageParams):
        path: OutputPath = Field("tracks.csv", description="the CSV file, below the output folder")

    params: Params

    def setup(self) -> None:
        """Create the file. Raises FollowspotError if that is not possible."""
        super().setup()
        self.names = tuple(self.room.targets)

    def process(self, tracks: Tracks) -> None:
        """Add the rows of one frame."""
        values = np.concatenate([tracks.xyz, tracks.velocity, tracks.sigma], axis=1)
        start = f"{tracks.header.seq},{seconds(tracks.header.time)}"
        self.write(
            ROW % (start, self.names[target], STATES[state], *row)
            for target, state, row in zip(
                tracks.target.tolist(), tracks.state.tolist(), values.tolist(), strict=True
            )
        )
