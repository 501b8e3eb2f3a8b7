"""A recording played as if it were a live camera."""

from __future__ import annotations

import time
from functools import cached_property
from threading import Event
from typing import ClassVar

from followspot import Field, Source
from followspot.tracking import Frame
from followspot_cameras.video import Video


class Playback(Video):
    """Play a video file at its own speed; if the graph is too slow, the oldest frames are dropped.

    It shows on a recording how a graph behaves with a live camera. Frame f is captured at f / fps, as in the
    recording, and comes that long after the first one.
    """

    live: ClassVar[bool] = True

    class Params(Video.Params):
        speed: float = Field(1.0, gt=0, le=1000, unit="1", description="speed over that of the recording")

    params: Params

    @cached_property
    def stopped(self) -> Event:
        """Ends the waiting when it is set."""
        return Event()

    def process(self) -> Source[Frame]:
        """Frames when they are due; overdue frames at once."""
        began, origin = 0.0, None
        try:
            for frame in super().process():
                captured = frame.header.time
                if origin is None:
                    began, origin = time.monotonic(), captured
                due = began + (captured - origin) / 1e9 / self.params.speed
                if self.stopped.wait(max(0.0, due - time.monotonic())):
                    break
                yield frame
        finally:
            self.capture.release()

    def close(self) -> None:
        """End the waiting, also from another thread; the one that reads the file closes it."""
        self.stopped.set()
