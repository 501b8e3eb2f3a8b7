"""Cameras that record for different times."""

from __future__ import annotations

import numpy as np

from followspot import Field, Joined, Latest, Source, Stage, StageParams
from followspot.messages import Header, stamped
from followspot.tracking import Frame


class Camera(Stage):
    """Gives ten frames a second."""

    class Params(StageParams):
        count: int = Field(30, ge=0, description="number of frames", unit="1")

    def process(self) -> Source[Frame]:
        frame = Frame(self.camera.name, np.zeros((4, 6, 3), np.uint8))
        for number in range(self.params.count):
            yield stamped(frame, Header("", -1, number * 100_000_000))


class Pass(Stage):
    """Gives the frames of one camera, whose last ones find others without a partner."""

    def process(self, frame: Frame, other: Latest[Frame] = None) -> Frame:
        return frame


class First(Stage):
    """Gives the frame of the first camera that has one."""

    def process(self, frames: Joined[Frame]) -> Frame:
        return frames[0]
