"""A look at a port, in the worker of the stage that sends there."""

from __future__ import annotations

import time

from followspot import Field, InputPath, Message, Stage, StageParams
from followspot.tracking import Frame
from followspot_dashboard.line import Line, PostLine, line_of
from followspot_dashboard.picture import picture_of
from followspot_dashboard.turn import GateTurn, GridTurn, Turn


class Tap(Stage):
    """Send previews of a port to those who look on; `followspot run --dashboard` adds one for each port.

    Pictures are made smaller here, and only while somebody looks. Whatever the page does not take at once is
    dropped: a tap never waits.
    """

    class Params(StageParams):
        folder: InputPath | None = Field(
            None, description="folder of the page's sockets, if the page is on this host"
        )
        port: str = Field("", description="observed port, STAGE.PORT; by default this stage's name")
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
    tap = True
    line: Line | PostLine | None = None

    def setup(self) -> None:
        """Find the page; without one, the tap passes everything over."""
        given = self.params
        self.port = given.port or self.context.name
        self.between = int(1e9 / given.message_rate) if given.message_rate else 0
        self.next_at = 0
        period = int(1e9 / given.picture_rate)
        self.line = line = line_of(self.context, given.folder)
        self.turn: Turn
        if isinstance(line, Line):
            self.turn = GateTurn(line.gate, period, leads=given.sets_times)
        else:
            self.turn = GridTurn(period)

    def process(self, message: Message) -> None:
        """Show the message, or pass it over. Raises EOFError when the page is gone."""
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
        """Whether one more is shown before the next picture."""
        return self.between > 0 and time.monotonic_ns() >= self.next_at

    def close(self) -> None:
        """Let go of the page."""
        if self.line is not None:
            self.line.close()
        self.line = None
