"""A recording played as if it were a live camera."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from functools import cached_property
from threading import Event
from typing import ClassVar

from followspot import Field, Source, at
from followspot.tracking import Frame
from followspot_cameras.video.stage import Video

_ONLY = 1_000_000_000
"""Time of the only frame of a recording, ns."""


class Playback(Video):
    """Play a video file at its own speed; if the graph is too slow, the oldest frames are dropped.

    It shows on a recording how a graph behaves with a live camera. Frame f is captured at f / fps, as in the
    recording, and comes that long after the first one. If its worker is started again, it goes on at the
    frame that is due then, as the other cameras do.
    """

    live: ClassVar[bool] = True
    _began = 0.0
    """When the first frame was due, s since 1970; 0 before."""

    class Params(Video.Params):
        speed: float = Field(1.0, gt=0, le=1000, unit="1", description="speed over that of the recording")
        loop: bool = Field(False, description="whether to play it again and again; times and numbers go on")

    params: Params

    @cached_property
    def stopped(self) -> Event:
        """Ends the waiting when it is set."""
        return Event()

    def process(self) -> Source[Frame]:
        """Frames when they are due; overdue frames at once."""
        began, origin, late = 0.0, None, self._began > 0.0
        first = self.capture_time(0)
        try:
            for frame in self._rounds():
                captured = frame.header.time
                if origin is None:
                    self._began = self._began or time.time()
                    began, origin = time.monotonic() - self._played(), captured if first is None else first
                due = began + (captured - origin) / 1e9 / self.params.speed
                late = late and due < time.monotonic()
                if late:
                    continue
                if self.stopped.wait(max(0.0, due - time.monotonic())):
                    break
                yield frame
        finally:
            self.capture.release()

    def length(self) -> int | None:
        """See `Video.length`; None for a recording that is played again and again."""
        return None if self.params.loop else super().length()

    def state(self) -> dict[str, float] | None:
        """When it began, s since 1970, and its speed."""
        return {"began": self._began, "speed": self.params.speed} if self._began else None

    def restore(self, state: Mapping[str, float]) -> None:
        """Go on where the recording is by now; at another speed from there on."""
        now = time.time()
        self._began = now - (now - state["began"]) * state["speed"] / self.params.speed

    def _played(self) -> float:
        """For how long it plays, s."""
        return time.time() - self._began if self._began else 0.0

    def _rounds(self) -> Iterator[Frame]:
        """The frames of the recording, with `loop` again and again: a frame's time after the last one.

        Rounds that are over already are passed over.
        """
        later, ahead = self._rounds_over()
        while True:
            first = last = None
            played = 0
            for frame in super().process():
                first, last, played = first or frame.header, frame.header, played + 1
                yield at(last.time + later, frame, seq=last.seq + ahead) if later else frame
            if not self.params.loop or first is None or last is None or self.stopped.is_set():
                return
            span = last.time - first.time
            later += span + (span // (played - 1) if played > 1 else _ONLY)
            ahead += last.seq + 1 - first.seq
            self.setup()

    def _rounds_over(self) -> tuple[int, int]:
        """The time, ns, and the frames of the whole rounds played; 0 if the length of the file is unknown."""
        frames = super().length() or 0
        first, last = self.capture_time(0), self.capture_time(frames - 1)
        if not self.params.loop or frames < 2 or first is None or last is None:
            return 0, 0
        span = last - first + (last - first) // (frames - 1)
        over = int(self._played() * 1e9 * self.params.speed) // span
        return over * span, over * frames

    def close(self) -> None:
        """End the waiting, also from another thread; the one that reads the file closes it."""
        self.stopped.set()
