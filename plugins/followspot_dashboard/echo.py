"""Every message of a port, for `followspot echo`."""

from __future__ import annotations

from followspot import Field, Message
from followspot.tracking import Frame
from followspot_dashboard.observer import Observer
from followspot_dashboard.picture import picture_of


class Echo(Observer):
    """Send every message of a port to `followspot echo`; messages that it does not take at once are dropped.

    Frames are sent as small pictures.
    """

    class Params(Observer.Params):
        maximum_side: int = Field(
            320, ge=16, le=1920, unit="px", description="longest side of a picture; raising it costs time"
        )

    params: Params

    def process(self, message: Message) -> None:
        """Send the message. Raises EOFError if the reader has left."""
        line = self.line
        if line is not None and line.deserted:
            raise EOFError("the reader has left")
        if line is None or not line.watched:
            return
        sent = picture_of(message, self.params.maximum_side) if isinstance(message, Frame) else message
        if sent is not None:
            line.send(self.port, sent)
