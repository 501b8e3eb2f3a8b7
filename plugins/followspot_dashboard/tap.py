"""Previews of a port for the page, made in the worker of the stage that sends."""

from __future__ import annotations

import time

from followspot import Field, Message
from followspot.tracking import Frame
from followspot_dashboard.line import Line
from followspot_dashboard.observer import Observer
from followspot_dashboard.picture import picture_of
from followspot_dashboard.turn import GateTurn, GridTurn, Turn


class Tap(Observer):
    """Send previews of a port to the page; `followspot run --dashboard` adds a tap for each port.

    The tap shrinks pictures, and only while a browser shows them. It drops what the page does not take at
    once: a tap never waits.
    """

    class Params(Observer.Params):
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

    params: Params

    def setup(self) -> None:
        """Connect to the page; without one, the tap ignores every message."""
        super().setup()
        given = self.params
        self.between = int(1e9 / given.message_rate) if given.message_rate else 0
        self.next_at = 0
        period = int(1e9 / given.picture_rate)
        self.turn: Turn
        if isinstance(self.line, Line):
            self.turn = GateTurn(self.line.gate, period, leads=given.sets_times)
        else:
            self.turn = GridTurn(period)

    def process(self, message: Message) -> None:
        """Show or ignore the message. Raises EOFError if the page has ended."""
        line = self.line
        if line is None:
            return
        if not (self.turn.has_come(message.header.time) or self._between_pictures()):
            return
        self.next_at = time.monotonic_ns() + self.between
        if not isinstance(message, Frame):
            line.send(self.port, message)
        elif line.watched and (picture := picture_of(message, self.params.maximum_side)) is not None:
            line.send(self.port, picture)

    def _between_pictures(self) -> bool:
        """Whether one more message is shown before the next picture."""
        return self.between > 0 and time.monotonic_ns() >= self.next_at
