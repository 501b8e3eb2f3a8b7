"""Every message of a port, for those who read along in a terminal."""

from __future__ import annotations

from followspot import Field, InputPath, Message, Stage, StageParams
from followspot.tracking import Frame
from followspot_dashboard.line import Line, PostLine, line_of
from followspot_dashboard.picture import picture_of


class Echo(Stage):
    """Send every message of a port to `followspot echo`; what it does not take at once is dropped.

    Of a frame a small picture is sent.
    """

    class Params(StageParams):
        folder: InputPath | None = Field(
            None, description="folder of the reader's sockets, if the reader is on this host"
        )
        port: str = Field("", description="observed port, STAGE.PORT; by default this stage's name")
        maximum_side: int = Field(
            320, ge=16, le=1920, unit="px", description="longest side of a picture; raising it costs time"
        )

    params: Params
    tap = True
    line: Line | PostLine | None = None

    def setup(self) -> None:
        """Find who reads; without them, all is passed over."""
        self.port = self.params.port or self.context.name
        self.line = line_of(self.context, self.params.folder)

    def process(self, message: Message) -> None:
        """Send the message. Raises EOFError when nobody reads any more."""
        line = self.line
        if line is not None and line.deserted:
            raise EOFError("nobody reads any more")
        if line is None or not line.watched:
            return
        sent = picture_of(message, self.params.maximum_side) if isinstance(message, Frame) else message
        if sent is not None:
            line.send(self.port, sent)

    def close(self) -> None:
        """Let go of the line."""
        if self.line is not None:
            self.line.close()
        self.line = None
