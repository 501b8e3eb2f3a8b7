"""A sink that records any port: the exact messages, and copies for viewers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

from followspot import Field, Message, OutputPath, Stage, StageParams
from followspot.errors import FollowspotError
from followspot.messages import stamped
from followspot.wire import differenced, pack
from followspot_recording.contract import contract_of, type_name
from followspot_recording.foxglove import Pictures, cameras_of, log_line, view_of
from followspot_recording.recorder import Chunking, Compression, Recorder, Schema, join, leave
from followspot_recording.schemas import LOG
from followspot_recording.topics import ENCODING, exact_topic, view_topic

MIB = 1 << 20


class RecordingSink(Stage):
    """Write every message into an MCAP file that it shares with the other recording sinks of its worker.

    Each message is kept exactly, and pictures, tracks and poses a second time as viewers know them.
    `followspot run --record FILE` adds one for each port.
    """

    class Params(StageParams):
        path: OutputPath = Field(
            "recording.mcap", description="the file; a number is added to the name if it exists"
        )
        port: str = Field("", description="recorded port, STAGE.PORT; by default this stage's name")
        picture_format: Literal["jpeg", "png", "raw", "none"] = Field(
            "jpeg", description="how frames are kept for viewers, beside the exact ones"
        )
        compression: Compression = Field(
            "zstd",
            description="zstd is small, for it stores pictures as differences of their rows; lz4 is faster,"
            " with up to twice the bytes",
        )
        chunk_size: float = Field(
            4.0,
            gt=0,
            le=64,
            unit="MiB",
            description="size before compression; raising it compresses better and risks more",
        )
        chunk_time: float = Field(
            1.0,
            gt=0,
            le=60,
            unit="s",
            description="longest time of a chunk; raising it compresses better and risks more",
        )
        essential: bool = Field(True, description="whether the run fails if the disk is full")
        metadata: dict[str, str] = Field({}, description="facts to embed")
        attachments: dict[str, str] = Field({}, description="texts to embed, by file name")

    params: Params
    recorder: Recorder | None = None

    def setup(self) -> None:
        """Open the file, or share it with other sinks. Raises FollowspotError."""
        given = self.params
        self.path = self.context.out / given.path
        chunking = Chunking(int(given.chunk_size * MIB), given.chunk_time, given.compression)
        self.recorder = join(self.path, chunking)
        if self.recorder.path != self.path and self.recorder.users == 1:  # the first of the file says so
            self.context.warn(f"{self.path} exists; recording to {self.recorder.path.name} beside it")
        port = given.port or self.context.name
        self.topic, self.view = exact_topic(port), view_topic(port)
        self.pictures: Pictures = given.picture_format
        self.schema: Schema | None = None
        self.described = not (given.metadata or given.attachments)
        if not self.described:
            self.recorder.describe(given.metadata, given.attachments)

    def process(self, message: Message) -> None:
        """Write one message. Raises FollowspotError if the disk does not take it, if that is essential."""
        self.put(message)

    def put(self, message: Message, *, shown: bool = True) -> None:
        """As `process`; shown: whether viewers get their copy, too, which costs most of the time."""
        if self.recorder is None:
            raise FollowspotError(f"{self.context.name} has no file: it was not set up")
        with self._forgiving():
            self._write(self.recorder, message, shown)

    @contextmanager
    def _forgiving(self) -> Iterator[None]:
        """Warn of a full disk. Raises FollowspotError if the recording is essential."""
        try:
            yield
        except FollowspotError as error:
            if self.params.essential:
                raise
            self.context.warn(f"the recording ends here, the run goes on: {error}")

    def _write(self, recorder: Recorder, message: Message, shown: bool) -> None:
        kind = type(message)
        if self.schema is None:
            self.schema = Schema(type_name(kind), ENCODING, contract_of(kind))
        header = message.header
        if not self.described:
            self.described = True
            line = log_line(header.time, f"recording of {self.params.metadata.get('graph', 'a graph')}")
            recorder.add("/log", "json", LOG, header.time, 0, line)
            for topic, schema, data in cameras_of(self.room, header.time):
                recorder.add(topic, "json", schema, header.time, 0, data)
        exact = pack(stamped(message, header._replace(entered=0)))  # when it was computed is no part of it
        if self.params.compression == "zstd":
            exact = differenced(exact)
        recorder.add(self.topic, ENCODING, self.schema, header.time, header.seq, exact)
        view = view_of(message, self.room, self.pictures) if shown else None
        if view is not None:
            recorder.add(self.view, "json", view[0], header.time, header.seq, view[1])

    def note(self, name: str, text: str, time: int) -> None:
        """Note an event in the file, for readers of its facts and for viewers. time: ns. Raises as `process`.

        name: of the facts, each once.
        """
        if self.recorder is not None:
            self.recorder.note(name, {"text": text, "time": str(time)})
            self.recorder.add("/log", "json", LOG, time, 0, log_line(time, text))

    def complete(self) -> None:
        """Complete the file, so that others can read it; `process` may go on. Raises as `process`."""
        if self.recorder is not None:
            self.recorder.complete()

    def close(self) -> None:
        """Leave the file; the last one completes it. Raises FollowspotError, if that is essential."""
        if self.recorder is not None:
            recorder, self.recorder = self.recorder, None
            with self._forgiving():
                leave(self.path, recorder)
