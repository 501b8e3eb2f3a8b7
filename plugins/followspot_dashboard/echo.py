"""Every message of a port, for `followspot echo`."""

from __future__ import annotations

from followspot import Field, Message
from followspot.taps.port_tap import PortTap
from followspot.tracking import Frame
from followspot_dashboard.picture import picture_of


class Echo(PortTap):
    """Send every message of a port to `followspot echo`; messages that it does not take at once are dropped.

    Frames are sent as small pictures.
    """

    class Params(PortTap.Params):
        maximum_side: int = Field(
            320, ge=16, le=1920, unit="px", description="longest side of a picture; raising it costs time"
        )

    params: Params

    def process(self, message: Message) -> None:
        """Send the message. Raises EOFError if the reader has left."""
        if not self.awaited():
            return
        sent = picture_of(message, self.params.maximum_side) if isinstance(message, Frame) else message
        if sent is not None:
            self.send(sent)
