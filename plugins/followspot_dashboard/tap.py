"""Previews of a port for the page, made in the worker of the stage that sends."""

from __future__ import annotations

import time

from followspot import Field, InputPath, Message
from followspot.inertial import Inertial
from followspot.taps.port_tap import PortTap
from followspot_dashboard.gate import Gate
from followspot_dashboard.picture import FARTHEST, PICTURES, picture_of
from followspot_dashboard.preview_times import PeriodicTimes, PreviewTimes, SharedTimes
from followspot_dashboard.unshown_readings import UnshownReadings


class Tap(PortTap):
    """Send previews of a port to the page; `followspot run --dashboard` adds a tap for each port.

    The tap reduces pictures, and only while a browser shows them. A preview of inertial readings has all
    readings since the last preview. The tap drops previews that the page does not take at once: it never
    waits.
    """

    class Params(PortTap.Params):
        folder: InputPath | None = Field(None, description="folder of the page's gate, if on this host")
        sets_times: bool = Field(
            False, description="whether this tap chooses the capture times that all taps show; for a source"
        )
        picture_rate: float = Field(
            10.0, gt=0, le=60, unit="1/s", description="number of capture times shown per second"
        )
        message_rate: float = Field(
            0.0,
            ge=0,
            le=60,
            unit="1/s",
            description="number of further messages shown per second, between those",
        )
        maximum_side: int = Field(
            320, ge=16, le=1920, unit="px", description="longest side of a picture; raising it costs time"
        )
        farthest: float = Field(
            FARTHEST, gt=0, le=1000, unit="m", description="depth that has the last colour of a depth image"
        )
        watched_only: bool = Field(
            False,
            description="whether messages are sent only while a browser shows the page, as pictures are",
        )

    params: Params
    gate: Gate | None = None

    def setup(self) -> None:
        """Connect to the page. One that has gone is reported at the first message."""
        super().setup()
        given = self.params
        self.between = int(1e9 / given.message_rate) if given.message_rate else 0
        self.next_at = 0
        self.unshown = UnshownReadings()
        period = int(1e9 / given.picture_rate)
        self.times: PreviewTimes = PeriodicTimes(period)
        if given.folder is not None:
            try:
                self.gate = Gate(given.folder)
            except OSError:
                self.gone = True
                return
            self.times = SharedTimes(self.gate, period, leads=given.sets_times)

    def process(self, message: Message) -> None:
        """Show or ignore the message. Raises EOFError if the page has ended."""
        if self.gone:
            raise EOFError("the page has ended")
        if isinstance(message, Inertial):
            self.unshown.add(message)
        if not (self.times.is_shown(message.header.time) or self._between_pictures()):
            return
        self.next_at = time.monotonic_ns() + self.between
        given = self.params
        if isinstance(message, PICTURES):
            picture = picture_of(message, given.maximum_side, given.farthest) if self._watched() else None
            if picture is not None:
                self.send(picture)
        elif not (self._watched() or (self.gate is not None and not given.watched_only)):
            self.unshown.clear()
        else:
            self.send(self.unshown.take() if isinstance(message, Inertial) else message)

    def close(self) -> None:
        """Disconnect from the page."""
        super().close()
        if self.gate is not None:
            self.gate.close()

    def _watched(self) -> bool:
        """Whether a browser shows pictures; on another host, whether the page takes this port."""
        if self.gate is not None:
            return self.gate.watched
        return self.context.post is not None and self.context.post.wanted

    def _between_pictures(self) -> bool:
        """Whether one more message is shown before the next picture."""
        return self.between > 0 and time.monotonic_ns() >= self.next_at
