"""Recorded ground truth of persons' poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from followspot import Field, InputPath, Source, Stage, StageParams, at
from followspot.errors import InputError, Mistake
from followspot.people import PoseTruth
from followspot_accuracy import read_pose_truth_csv
from followspot_cameras.recordings import POSE_TRUTH


class PoseTruthCsv(Stage):
    """Ground truth of persons from a CSV file, or from a folder with a file CAMERA_gt.csv for each camera.

    Columns: time (s), person, x, y, z_head_top, r (m), torso_heading_room, torso_heading, head_pan,
    head_tilt (rad), visible_upper (0 to 1). A person is as visible as in the camera that sees most of the
    person.
    """

    class Params(StageParams):
        path: InputPath = Field(description="the CSV file or the folder; more columns are ignored")

    params: Params

    def setup(self) -> None:
        """Read everything. Raises InputError with line numbers."""
        self.truth = read_pose_truth_csv(*self.files())

    def files(self) -> list[Path]:
        """The CSV files. Raises InputError for a folder that has none for the room's cameras."""
        path = self.params.path
        if not path.is_dir():
            return [path]
        files = [file for name in self.room.cameras if (file := path / f"{name}{POSE_TRUTH}").is_file()]
        if not files:
            names = ", ".join(f"{name}{POSE_TRUTH}" for name in self.room.cameras)
            raise InputError([Mistake(None, f"{path} has no truth of this room's cameras", f"add {names}")])
        return files

    def length(self) -> int:
        """Number of frames."""
        return len(self.truth.time)

    def process(self) -> Source[PoseTruth]:
        """One message per time, with the persons that are present."""
        truth = self.truth
        persons = np.array(truth.persons, "i4")
        there = np.isfinite(truth.pose[..., 0])
        for f, time in enumerate(truth.time):
            rows = there[f]
            pose = truth.pose[f, rows]
            yield at(
                round(time * 1e9),
                PoseTruth(
                    person=persons[rows],
                    xy=pose[:, :2],
                    height=pose[:, 2],
                    heading=pose[:, 3],
                    pan=pose[:, 4],
                    tilt=pose[:, 5],
                    visible=truth.visible[f, rows],
                ),
                seq=f,
            )
