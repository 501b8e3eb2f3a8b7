"""The tap that sends every message of a port to a receiver."""

from __future__ import annotations

from followspot.messages import Message
from followspot.stage import Stage
from followspot.stage_params import Field, InputPath, StageParams
from followspot.taps.framing import head_of
from followspot.taps.sender import TapSender, acquire, release
from followspot.wire import pack


class PortTap(Stage):
    """Send every message of a port to a receiver in another process.

    The worker packs the message; a thread sends it. The tap drops what the receiver does not take in time,
    and the receiver counts the gaps in the numbers.
    """

    class Params(StageParams):
        socket: InputPath | None = Field(None, description="socket of the receiver, if on this host")
        port: str = Field("", description="port that is tapped, STAGE.PORT; this stage's name unless told")

    params: Params
    tap = True
    sender: TapSender | None = None
    gone = False
    read_before = False

    def setup(self) -> None:
        """Connect to the receiver. One that has gone is reported at the first message."""
        self.port = self.params.port or self.context.name
        self.number = 0
        if self.params.socket is not None:
            try:
                self.sender = acquire(self.params.socket)
            except OSError:
                self.gone = True

    def process(self, message: Message) -> None:
        """Send the message, or drop it. Raises EOFError if the receiver has gone."""
        if self.awaited():
            self.send(message)

    def awaited(self) -> bool:
        """Whether a receiver is there. Raises EOFError if it has gone."""
        post = self.context.post
        wanted = self.sender is not None if post is None else post.wanted
        if self.gone or (self.read_before and not wanted):
            raise EOFError("the receiver of the tap has gone")
        self.read_before |= wanted
        return wanted

    def send(self, message: Message) -> None:
        """Send the message, or drop it. Raises EOFError if the receiver on this host has gone."""
        packed = pack(message)
        if self.sender is not None:
            self.sender.send(self.port, self.number, packed)
        elif self.context.post is not None:
            self.context.post.send(head_of(self.port, self.number, packed) + packed)
        self.number += 1

    def close(self) -> None:
        """Close the connection."""
        if self.context.post is not None:
            self.context.post.close()
        if self.sender is not None and self.params.socket is not None:
            release(self.params.socket)
        self.sender = None
