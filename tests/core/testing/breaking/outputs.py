"""Stages that send what they do not declare."""

from __future__ import annotations

import numpy as np

from followspot import Deferred, Lagged, Outputs, Stage, at
from followspot.tracking import Blobs, Frame, Tracks


class Reusing(Stage):
    """Sends one array again and again."""

    def setup(self) -> None:
        self.pixels = np.zeros((4, 4, 1), np.uint8)

    def process(self, frame: Frame) -> Frame:
        self.pixels.flags.writeable = True
        self.pixels += 1
        return Frame(frame.camera, self.pixels)


class WrongType(Stage):
    """Returns what it does not declare."""

    def process(self, blobs: Blobs) -> Tracks:
        return blobs  # type: ignore[return-value]


class NoMessage(Stage):
    """Returns no message at all."""

    def process(self, blobs: Blobs) -> Tracks:
        return [blobs]  # type: ignore[return-value]


class Timed(Stage):
    """Says at which time its result was captured, though it is no source."""

    def process(self, blobs: Blobs) -> Blobs:
        return at(blobs.header.time - 1, blobs)


class Hasty(Stage):
    """Gives a message for a firing that is yet to come."""

    def process(self, frame: Frame) -> Lagged[Frame]:
        return [at(frame.header.time + 1, Frame(frame.camera, frame.pixels))]


class Unending(Stage):
    """Gives what remains without times."""

    def process(self, frame: Frame) -> Lagged[Frame]:
        self.frame = frame
        return ()

    def remaining(self) -> list[Frame]:
        return [Frame(self.frame.camera, self.frame.pixels)]


class EarlyOutputs(Stage):
    """Gives several messages, one before the time of the firing."""

    def process(self, blobs: Blobs) -> Outputs[Blobs]:
        return blobs, at(blobs.header.time - 1, blobs)


class LateAnswer(Stage):
    """Answers later, with a message of another type."""

    def process(self, blobs: Blobs) -> Deferred[Tracks]:
        return lambda: blobs  # type: ignore[return-value]


class WrongShape(Stage):
    """Returns arrays of other shapes than it declares."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, np.zeros((2, 2), np.uint8))


class Stranger(Stage):
    """Speaks of no camera of the room."""

    def process(self, frame: Frame) -> Blobs:
        return Blobs.empty()
