"""A plugin file for benchmarks: cameras that play a video from memory, in whatever process they are."""

from __future__ import annotations

from pathlib import Path

import cv2

from followspot import Array, Field, Source, Stage, StageParams, at
from followspot.tracking import Frame


class Preloaded(Stage):
    """Play a video, decoded in `setup` before the clock starts, with the pixels that the room has."""

    per_camera = True

    class Params(StageParams):
        path: Path = Field(description="the video file")
        frames: int = Field(description="most frames to play", unit="1")

    params: Params

    def setup(self) -> None:
        """Decode the file."""
        reader = cv2.VideoCapture(str(self.params.path))
        self.period = 1e9 / reader.get(cv2.CAP_PROP_FPS)
        self.pictures: list[Array] = []
        while len(self.pictures) < self.params.frames and (picture := reader.read()[1]) is not None:
            self.pictures.append(cv2.resize(picture, self.camera.size, interpolation=cv2.INTER_LINEAR))
        reader.release()

    def process(self) -> Source[Frame]:
        """Each picture, copied into its message as a device would."""
        for number, picture in enumerate(self.pictures):
            yield at(round(number * self.period), Frame(self.camera.name, picture.copy()))
