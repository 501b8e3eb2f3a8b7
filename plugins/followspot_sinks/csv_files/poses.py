"""Poses of persons as a CSV file."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, OutputPath, StageParams
from followspot.geometry import direction, seen_from_above, wrap
from followspot.people import Poses
from followspot.room import Camera
from followspot_sinks.line_sink import LineSink, seconds


class CsvPoses(LineSink):
    """Write one row per person and frame: m, rad, confidence from 0 to 1, and the camera that saw it.

    phi, r and torso_heading are relative to that camera (phi 0: its axis, torso_heading 0: the chest faces
    it); of poses fused from several cameras, whose camera is empty, relative to the room.
    """

    head = "frame,time,person,x,y,z_head_top,phi,r,torso_heading,head_pan,head_tilt,confidence,camera\n"

    class Params(StageParams):
        path: OutputPath = Field("poses.csv", description="the CSV file, below the output folder")

    params: Params

    def process(self, poses: Poses) -> None:
        """Add the rows of one frame."""
        camera = self.room.cameras[poses.camera] if poses.camera else None
        phi, r, torso = as_seen(camera, poses.xy, poses.heading)
        values = np.column_stack(
            [poses.xy, poses.height, phi, r, torso, poses.pan, poses.tilt, poses.confidence]
        )
        start = f"{poses.header.seq},{seconds(poses.header.time)}"
        self.write(
            f"{start},{person}," + ",".join(f"{v:.4f}" for v in row) + f",{poses.camera}\n"
            for person, row in zip(poses.person.tolist(), values.tolist(), strict=True)
        )


def as_seen(camera: Camera | None, xy: Array, heading: Array) -> tuple[Array, Array, Array]:
    """Direction, distance and heading relative to the camera, of (M, 2) m and (M,) rad; None: to the room."""
    if camera is None:
        return direction(xy), np.hypot(xy[:, 0], xy[:, 1]), wrap(heading)
    phi, r = seen_from_above(camera, xy)
    return phi, r, wrap(heading - direction(camera.center[:2] - xy))
