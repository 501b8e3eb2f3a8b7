"""Live cameras: grab pictures, and connect again when they stop."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from functools import cached_property
from threading import Event
from typing import Any, ClassVar, Protocol

from followspot import Source, Stage, at
from followspot.messages import Array
from followspot.tracking import Frame
from followspot_cameras.picture import as_frame, color_buffer

FIRST_WAIT, LONGEST_WAIT = 0.5, 10.0
"""Pause before connecting again, s; it doubles with every failure."""


class Capture(Protocol):
    """The methods of cv2.VideoCapture that live cameras use."""

    def isOpened(self) -> bool:  # noqa: N802
        """Whether the camera answers."""

    def grab(self) -> bool:
        """Wait for the next picture; False if none comes."""

    def retrieve(self, image: Array | None = None, /) -> tuple[bool, Any]:
        """Decode the grabbed picture, into `image` if it fits."""

    def get(self, property: int, /) -> float:  # noqa: A002  # as OpenCV has it
        """A property of the camera, or of the grabbed picture."""

    def release(self) -> None:
        """Release the camera."""


class LiveCamera(Stage, ABC):
    """Base of live sources: subclasses connect to the camera and name it."""

    live: ClassVar[bool] = True
    per_camera: ClassVar[bool] = True
    origin: str
    """The camera's address as users know it, without secrets."""

    @abstractmethod
    def connect(self) -> Capture:
        """Open the camera once; `isOpened` gives the result."""

    @cached_property
    def stopped(self) -> Event:
        """Ends the waiting when it is set."""
        return Event()

    def process(self) -> Source[Frame]:
        """Frames as they come, each with its capture time, ns since 1970."""
        camera, loan = self.camera, self.context.loan
        for capture in grabs(self.connect, self.stopped, self.report):
            captured = self.captured(capture)
            ok, image = capture.retrieve(color_buffer(camera, loan))
            if ok:
                yield at(captured, as_frame(image, camera, loan, self.origin))

    def captured(self, capture: Capture) -> int:
        """Capture time of the grabbed picture, ns since 1970: the present if nothing better is known."""
        return time.time_ns()

    def report(self, text: str) -> None:
        """Warn with the camera's address."""
        self.context.warn(f"{self.origin} {text}")

    def close(self) -> None:
        """End the waiting, also from another thread."""
        self.stopped.set()


def grabs(connect: Callable[[], Capture], stopped: Event, report: Callable[[str], None]) -> Iterator[Capture]:
    """The capture, once for each picture that it grabbed; connects again with exponential back-off.

    Reports each loss and each recovery once. Ends when `stopped` is set.
    """
    wait, lost = FIRST_WAIT, False
    while not stopped.is_set():
        capture = connect()
        try:
            while not stopped.is_set() and capture.isOpened() and capture.grab():
                if lost:
                    report("is back")
                wait, lost = FIRST_WAIT, False
                yield capture
        finally:
            capture.release()
        if not lost and not stopped.is_set():
            report("gives no pictures; connecting again until it does")
        lost = True
        stopped.wait(wait)
        wait = min(2 * wait, LONGEST_WAIT)
