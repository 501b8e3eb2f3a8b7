"""Live streams through OpenCV, whose pictures are captured when they arrive."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Iterator
from typing import Any, Protocol

from followspot import at
from followspot.messages import Array
from followspot.tracking import Frame
from followspot_cameras.picture import as_frame, color_buffer
from followspot_cameras.reconnection import LiveCamera


class Capture(Protocol):
    """The methods of cv2.VideoCapture that live cameras use."""

    def isOpened(self) -> bool:  # noqa: N802
        """Whether the camera answers."""

    def grab(self) -> bool:
        """Wait for the next picture; False if none comes."""

    def retrieve(self, image: Array | None = None, /) -> tuple[bool, Any]:
        """Decode the grabbed picture, into `image` if it fits."""

    def release(self) -> None:
        """Release the camera."""


class CaptureCamera(LiveCamera):
    """Base of live sources through OpenCV: subclasses connect to the camera and name it."""

    @abstractmethod
    def connect(self) -> Capture:
        """Open the camera once; `isOpened` gives the result."""

    def session(self) -> Iterator[Frame]:
        """Frames of one connection, each with its capture time, ns since 1970. Raises ConnectionError."""
        camera, loan = self.camera, self.context.loan
        capture = self.connect()
        try:
            while not self.stopped.is_set() and capture.isOpened() and capture.grab():
                captured = time.time_ns()
                ok, image = capture.retrieve(color_buffer(camera, loan))
                if ok:
                    yield at(captured, as_frame(image, camera, loan, self.origin))
        finally:
            capture.release()
        raise ConnectionError("no picture came")
