"""A recording played as if it were a live camera."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from threading import Event
from typing import Any, ClassVar

from followspot import Field, Source, at
from followspot.tracking import Frame
from followspot_cameras.video.stage import Video

_ONLY = 1_000_000_000
"""Time of the only frame of a recording, ns."""
_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
"""File with a name for this start of the computer."""
_MAXIMUM_AWAY = 600.0
"""Time between a state and its restoration beyond which the wall clocks cannot be right, s."""


class Playback(Video):
    """Play a video file at its own speed; if the graph is too slow, the oldest frames are dropped.

    It shows on a recording how a graph behaves with a live camera. Frame f is captured at f / fps, as in the
    recording, and comes that long after the first one. If its worker is started again, it goes on at the
    frame that is due then, as the other cameras do.
    """

    live: ClassVar[bool] = True
    _began: float | None = None
    """When the first frame was due, s, monotonic; None before."""

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
        began, origin, late = 0.0, None, self._began is not None
        first = self.capture_time(0)
        try:
            for frame in self._rounds():
                captured = frame.header.time
                if origin is None:
                    began = self._began = time.monotonic() if self._began is None else self._began
                    origin = captured if first is None else first
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

    def state(self) -> dict[str, Any] | None:
        """When it began, by which host's monotonic clock; how long it has played by now; its speed."""
        if self._began is None:
            return None
        here = {"began": self._began, "computer": _BOOT_ID.read_text()}
        return {**here, "played": self._played(), "now": time.time(), "speed": self.params.speed}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on where the recording is by now; at another speed from there on.

        All processes of a host have one monotonic clock. Another host goes by the wall clock, or goes
        on where the recording was if that clock cannot be right.
        """
        now, away = time.monotonic(), time.time() - state["now"]
        played = state["played"] + (away if 0 <= away <= _MAXIMUM_AWAY else 0.0)
        if state["computer"] == _BOOT_ID.read_text():
            played = now - state["began"]
        self._began = now - played * state["speed"] / self.params.speed

    def _played(self) -> float:
        """For how long it has played, s."""
        return 0.0 if self._began is None else time.monotonic() - self._began

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
