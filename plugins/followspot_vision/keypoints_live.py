"""Joints of persons that another program finds now and writes into a folder, picture by picture."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import ClassVar

from followspot import Field, InputPath, Source, Stage, at
from followspot.errors import InputError
from followspot.frame_times import capture_time, exact_rate
from followspot.points import Points2D
from followspot_vision.keypoint_files import Person, picture_files, read_picture
from followspot_vision.keypoints_json import joints_of, of_camera
from followspot_vision.picture_points import PictureParams, points_of


class KeypointsLive(Stage):
    """Joints of persons from a folder into which OpenPose or MMPose writes a JSON file for each picture.

    Files that are there at the start are old and are left out. If a file cannot be read yet, the stage tries
    again; after some time it leaves the file out, with a warning. It also leaves out files that come after
    those of later pictures, and files that a restarted network writes anew.
    """

    per_camera: ClassVar[bool] = True
    live: ClassVar[bool] = True

    class Params(PictureParams):
        """The folder, the times of its pictures and their frame of reference."""

        path: InputPath = Field(description="the camera's folder, or a folder with CAMERA/ for each camera")
        fps: float | None = Field(
            None,
            ge=0.001,
            le=100_000,
            unit="1/s",
            description="frame rate: picture n was taken at n / fps; by default when its file was written",
        )
        joints: tuple[str, ...] = Field(
            (), description="names of the joints; by default those of COCO (17) or OpenPose (18, 25)"
        )
        poll_interval: float = Field(
            0.02, ge=0.001, le=10, unit="s", description="time between two looks into the folder"
        )
        read_timeout: float = Field(
            1.0,
            ge=0,
            le=60,
            unit="s",
            description="time after which a file that cannot be read is left out; raising it tolerates "
            "networks that write slowly, and delays the pictures after a broken file",
        )

    params: Params

    @classmethod
    def nominal_rate(cls, params: Params) -> float | None:
        """The frame rate, if it is given."""
        return params.fps

    def setup(self) -> None:
        """List the folder. Raises InputError if it is no folder."""
        self.folder = of_camera(self.params.path, self.camera.name, self.room.cameras)
        if not self.folder.is_dir():
            raise InputError.of(f"{self.folder} is no folder", "name the folder that the network writes into")
        self.gone = False
        there = dict(self.pictures())
        self.known = set(there)
        """Numbers of the pictures whose files were there."""
        self.last = max(there, default=-1)
        self.written = _written(there[self.last]) if there else 0
        """When the file of the last picture was written, ns."""
        self.told = False

    def process(self) -> Source[Points2D]:
        """A message for each picture when its file is complete, in the order of their numbers."""
        while self.context.pause(self.params.poll_interval):
            there = self.pictures()
            self.tell_old(dict(there))
            for number, path in [one for one in there if one[0] > self.last]:
                persons = self.persons(path)
                self.last, self.written = number, _written(path)
                if persons is not None:
                    yield from self.message(number, path, persons)

    def tell_old(self, there: Mapping[int, Path]) -> None:
        """Warn, once, of new files of pictures that are not later than the last. there: by their numbers."""
        late = [number for number in there if number < self.last and number not in self.known]
        self.known.update(there)
        first = min(there, default=self.last)
        if not late and first < self.last and _written(there[first]) > self.written:
            late = [first]
        if late and not self.told:
            self.told = True
            self.context.warn(
                f"{there[late[0]]} was written after picture {self.last} and is left out, as others will be: "
                "have pictures written in their order; before a network begins anew, empty the folder and "
                "stop the run"
            )

    def pictures(self) -> list[tuple[int, Path]]:
        """The files of the folder by the numbers of their pictures; none while it is gone, with a warning.

        Raises InputError.
        """
        try:
            found = picture_files(self.folder, self.room.cameras)
        except FileNotFoundError:
            if not self.gone:
                self.context.warn(f"{self.folder} is gone: no joints until it is there again")
            self.gone = True
            return []
        self.gone = False
        return found

    def persons(self, path: Path) -> list[Person] | None:
        """The persons of a picture as soon as its file can be read; None if it never can."""
        until = time.monotonic() + self.params.read_timeout
        while True:
            try:
                return read_picture(path)
            except InputError as error:
                if time.monotonic() > until or not self.context.pause(self.params.poll_interval):
                    self.context.warn(f"left out: {error}")
                    return None

    def message(self, number: int, path: Path, persons: list[Person]) -> Iterator[Points2D]:
        """The joints of one picture. Raises InputError if they have no names."""
        rate = self.params.fps
        found = joints_of(persons, self.params, self.params.joints, str(path))
        written = self.written or time.time_ns()  # a file may be removed as soon as it was read
        when = capture_time(number, exact_rate(rate)) if rate else written
        yield at(when, points_of(found, self.camera, self.params), seq=number)


def _written(path: Path) -> int:
    """When a file was written, ns; 0 if it is gone."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0
