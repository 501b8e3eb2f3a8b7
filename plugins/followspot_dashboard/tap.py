"""A look at a port, in the worker of the stage that sends there."""

from __future__ import annotations

import time
from pathlib import Path

from followspot import Field, Message, Stage, StageParams
from followspot.tracking import Frame
from followspot_dashboard.gate import Gate
from followspot_dashboard.line import Line
from followspot_dashboard.pace import Pace
from followspot_dashboard.picture import picture_of


class Tap(Stage):
    """Send previews of a port to those who look on; `followspot run --dashboard` adds one for each port.

    Pictures are made smaller here, and only while somebody looks. Whatever the page does not take at once is
    dropped: a tap never waits.
    """

    class Params(StageParams):
        folder: str = Field("", description="folder of the page; no previews where it is not there")
        port: str = Field("", description="port that is looked at, STAGE.PORT; this stage's name unless told")
        leads: bool = Field(False, description="whether it names the moments to show: a tap of a source")
        rate: float = Field(10.0, gt=0, le=60, description="pictures to show", unit="1/s")
        smooth: float = Field(
            0.0, ge=0, le=60, description="messages to show besides, between two pictures", unit="1/s"
        )
        every: bool = Field(False, description="whether every message is shown, whatever its moment")
        longest: int = Field(320, ge=16, le=1920, description="longest side of a picture", unit="px")

    params: Params
    gate: Gate | None = None
    line: Line | None = None

    def setup(self) -> None:
        """Find the page; without one, the tap passes everything over."""
        given = self.params
        self.port = given.port or self.context.name
        self.period = int(1e9 / given.rate)
        self.between = int(1e9 / given.smooth) if given.smooth else 0
        self.shown = -1
        self.next_at = 0
        self.pace = Pace()
        if given.folder:
            try:
                self.gate = Gate(Path(given.folder))
                self.line = Line(Path(given.folder))
            except OSError as error:
                self.context.warn(f"there is no page to send previews to: {error}")
                self.close()

    def process(self, message: Message) -> None:
        """Show the message, or pass it over. Raises EOFError when the page is gone."""
        gate = self.gate
        if gate is None:
            return
        if self.params.every:
            self._show(message, gate)
            return
        captured = message.header.time
        moment = gate.moment(captured)
        if self.params.leads:
            self._lead(gate, captured)
        if captured >= moment != self.shown:
            self.shown = moment
        elif not self.between or time.monotonic_ns() < self.next_at:
            return
        self.next_at = time.monotonic_ns() + self.between
        self._show(message, gate)

    def _lead(self, gate: Gate, captured: int) -> None:
        """Name the next moment if it is due."""
        self.pace.add(captured)
        now = time.monotonic_ns()
        if gate.due(now, captured):
            gate.name(captured + self.pace.ahead(now, self.period), now + self.period)

    def _show(self, message: Message, gate: Gate) -> None:
        assert self.line is not None
        if not isinstance(message, Frame):
            self.line.send(self.port, message)
        elif gate.watched and (picture := picture_of(message, self.params.longest)) is not None:
            self.line.send(self.port, picture)

    def close(self) -> None:
        """Let go of the page."""
        for part in (self.line, self.gate):
            if part is not None:
                part.close()
        self.line = self.gate = None
