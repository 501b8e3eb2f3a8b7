"""Any port of a graph that runs to a recorder outside: a tap, which neither waits nor counts as an edge."""

from __future__ import annotations

from followspot import Field, InputPath, Message, Stage, StageParams
from followspot.stage import Post
from followspot.wire import pack
from followspot_recording.record_sender import RecordSender, acquire, head_of, release


class RecordingTap(Stage):
    """Hand every message of a port to a recorder in a process of its own.

    It is packed here and sent from another thread; what the recorder does not take in time is left out, and
    the recorder knows from the numbers how much that was.
    """

    class Params(StageParams):
        socket: InputPath | None = Field(None, description="where the recorder listens, if on this host")
        port: str = Field("", description="port that is recorded, STAGE.PORT; this stage's name unless told")

    params: Params
    tap = True
    sender: RecordSender | None = None
    heard = False

    def setup(self) -> None:
        """Find the recorder; one that has ended needs nothing more."""
        self.port = self.params.port or self.context.name
        self.number = 0
        if self.params.socket is not None:
            try:
                self.sender = acquire(self.params.socket)
            except OSError:
                return

    def process(self, message: Message) -> None:
        """Hand the message over, or leave it out. Raises EOFError when the recorder is gone."""
        if self.sender is not None:
            self.sender.send(self.port, self.number, pack(message))
            self.number += 1
        elif self.context.post is not None:
            self._post(self.context.post, message)

    def _post(self, post: Post, message: Message) -> None:
        """From another host: while a recorder listens, and until it has gone."""
        if post.wanted:
            self.heard = True
            packed = pack(message)
            post.send(head_of(self.port, self.number, packed) + packed)
            self.number += 1
        elif self.heard:
            raise EOFError("the recorder has gone")

    def close(self) -> None:
        """Let go of the recorder."""
        if self.context.post is not None:
            self.context.post.close()
        if self.sender is not None and self.params.socket is not None:
            release(self.params.socket)
        self.sender = None
