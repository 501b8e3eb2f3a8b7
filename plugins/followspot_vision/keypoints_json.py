"""Joints of persons that OpenPose, MMPose or a program with COCO's format found."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

import numpy as np

from followspot import Field, InputPath, Mistake, Room, Source, Stage, at
from followspot.errors import InputError
from followspot.frame_times import capture_time, exact_rate
from followspot.points import Points2D
from followspot.room import Member
from followspot_vision.frame_steps import doubt_of_gaps, doubt_of_steps
from followspot_vision.frame_table import MOST_FRAMES
from followspot_vision.keypoint_files import Person, picture_files, read_picture, read_results
from followspot_vision.picture_points import (
    Found,
    PictureParams,
    points_of,
    shares_as_pixels,
    wrong_unit,
)
from followspot_vision.skeletons import joint_names

_SMALL = 1_000_000
"""Bytes of a file that is read before a run."""


class KeypointsJson(Stage):
    """Joints of persons from the JSON files of OpenPose or MMPose (a folder with one for each picture), or
    from one file in COCO's format for results or of MMPose about a video.

    Each point has the joint's name as its label and the person's number in the picture as its instance.
    Joints with the score 0 were not found and are left out.
    """

    per_camera = True
    advice = "joints with the score 0 or below minimum_score are left out: look at the scores in the files"

    class Params(PictureParams):
        """The files, their times and their frame of reference."""

        path: InputPath = Field(
            description="the camera's file or folder, or a folder with CAMERA.json or CAMERA/ for each camera"
        )
        fps: float = Field(30.0, ge=0.001, le=100_000, unit="1/s", description="frame rate of the pictures")
        first_picture: int = Field(
            0, ge=0, unit="frames", description="number in the files of the picture at time 0"
        )
        joints: tuple[str, ...] = Field(
            (), description="names of the joints; by default those of COCO (17) or OpenPose (18, 25)"
        )

    params: Params

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Read the first picture of a folder, or the file if it is small. Raises InputError. Warn if it is in
        another unit.
        """
        place = of_camera(params.path, member.name, room.cameras) if member is not None else params.path
        if place.is_dir():
            persons = [
                one for _, path in picture_files(place, room.cameras)[:1] for one in read_picture(path)
            ]
        elif place.stat().st_size <= _SMALL:
            camera = member.name if member is not None else ""
            results = read_results(place, camera, room.cameras)
            persons = [person for found in results.values() for person in found]
        else:
            persons = []
        for count in sorted({len(person) for person in persons if person}):
            joint_names(count, params.joints, str(params.path))
        places = np.array([(one.x, one.y) for one in joints_of(persons, params, params.joints, str(place))])
        return shares_as_pixels(places, params, None)

    def setup(self) -> None:
        """Find the files. Raises InputError if they are none."""
        place = of_camera(self.params.path, self.camera.name, self.room.cameras)
        self.files = dict(picture_files(place, self.room.cameras)) if place.is_dir() else {}
        own, cameras = self.camera.name, self.room.cameras
        self.results = {} if place.is_dir() else read_results(place, own, cameras)
        numbers = [*self.files, *self.results]
        first = self.params.first_picture
        if numbers and min(numbers) < first:
            text = f"{place} begins with picture {min(numbers)}, before first_picture"
            raise InputError.of(text, f"with: {{first_picture: {min(numbers)}}}")
        self.count = max(numbers, default=first - 1) + 1 - first
        if self.count > MOST_FRAMES:
            text = f"{place} goes up to picture {max(numbers)}"
            raise InputError.of(text, f"at most {MOST_FRAMES} after first_picture")
        if not numbers:
            self.context.warn(f"{place} has no results")
        if doubt := doubt_of_steps(numbers, self.params.fps) or doubt_of_gaps(self.files):
            self.context.warn(f"{place}: {doubt}")

    def length(self) -> int:
        """Number of pictures."""
        return self.count

    def process(self) -> Source[Points2D]:
        """One message for each picture up to the last; empty for one without results."""
        rate = exact_rate(self.params.fps)
        for number in range(self.count):
            found = self.found(number + self.params.first_picture)
            yield at(capture_time(number, rate), points_of(found, self.camera, self.params), seq=number)

    def found(self, picture: int) -> list[Found]:
        """The joints of all persons. Raises InputError if the file is none."""
        persons: Sequence[Person] = self.results.get(picture, ())
        if picture in self.files:
            persons = read_picture(self.files[picture])
        return joints_of(persons, self.params, self.params.joints, str(self.params.path))


def joints_of(
    persons: Sequence[Person], given: PictureParams, names: Sequence[str], file: str
) -> list[Found]:
    """The joints that were found of all persons. names: the user's, if any. Raises InputError."""
    found = []
    for instance, person in enumerate(persons):
        own = joint_names(len(person), names, file) if person else ()
        joints = zip(own, person, strict=True)
        found += [Found(x, y, name, instance, score) for name, (x, y, score) in joints if score > 0]
    for one in found:
        if wrong := wrong_unit(one.x, given) or wrong_unit(one.y, given):
            text = f"{file}: {one.label} of person {one.instance} of a picture is at {one.x:g}, {one.y:g}"
            raise InputError.of(text, f"needs {wrong}")
    return found


def of_camera(path: Path, camera: str, cameras: Collection[str]) -> Path:
    """The file or folder of a camera: CAMERA.json or CAMERA below the path if there is one, else the path.

    Raises InputError if that has the name of another one of the room's cameras.
    """
    below = (path / f"{camera}.json", path / camera)
    place = next((place for place in below if place.exists()), path)
    if place == path and path.stem in cameras and path.stem != camera:
        text = f"{path} has the name of camera {path.stem}, and is read for {camera}, too"
        raise InputError.of(text, "name the folder that has a file or a folder for each camera")
    return place
