"""One MCAP file that all recording sinks of a worker write together."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NoReturn

from followspot.errors import FollowspotError
from followspot.files import removed, unused_path
from followspot.operating_system.limits import limit_remedy
from followspot_recording.writer import McapWriter

Compression = Literal["lz4", "zstd", "none"]
PROFILE = "followspot"
_MAX_COUNT = 100
"""Most messages of a chunk: the index of a chunk is kept until it is written."""


@dataclass(frozen=True)
class Chunking:
    """The division of a file into chunks; a killed process loses the last one.

    size: B before compression; seconds: longest time that messages wait for their chunk to be full.
    """

    size: int
    seconds: float
    compression: Compression


@dataclass(frozen=True)
class Schema:
    """The type of a channel's messages, as MCAP states it."""

    name: str
    encoding: str
    text: str


class Recorder:
    """An open file. It holds at most one chunk and one message in memory."""

    def __init__(self, path: Path, chunking: Chunking) -> None:
        """Create the file; an older one is never replaced. Raises FollowspotError."""
        self.path = path
        self.users = 0
        self._chunking = chunking
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._flushed = time.monotonic()
        self._broken = self._complete = False
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("xb")
        except OSError as error:
            raise FollowspotError(f"{path} cannot be written: {error.strerror}") from None
        self._writer = McapWriter(self._file, chunking.compression, profile=PROFILE)

    def describe(self, metadata: Mapping[str, str], attachments: Mapping[str, str]) -> None:
        """Embed facts about the run, and files by name. Raises FollowspotError as `add` does."""
        self.note("followspot", metadata)
        try:
            for name, text in attachments.items():
                kind = "application/json" if name.endswith(".json") else "application/yaml"
                self._writer.attach(name, kind, text.encode())
        except OSError as error:
            self._cut_short(error)

    def note(self, name: str, facts: Mapping[str, str]) -> None:
        """Embed facts under a name. Raises FollowspotError as `add` does."""
        if self._broken:
            return
        try:
            self._resume()
            self._writer.describe(name, dict(facts))
        except OSError as error:
            self._cut_short(error)

    def add(self, topic: str, encoding: str, schema: Schema, time_ns: int, seq: int, data: bytes) -> None:
        """Append a message. Raises FollowspotError once if the file was removed or the disk is full: it ends.

        time_ns: capture time; MCAP counts from 0, so earlier times are stored as 0.
        """
        if self._broken:
            return
        now = time.monotonic()
        overdue = now - self._flushed >= self._chunking.seconds
        try:
            self._resume()
            chunk = self._writer.chunk
            full = chunk.count == _MAX_COUNT or chunk.size + len(data) > self._chunking.size
            if full or overdue:
                self._require_file()
                self._writer.flush()
                self._flushed = now
            channel = self._channels.get(topic) or self._register(topic, encoding, schema)
            stamp = max(0, time_ns)
            self._writer.chunk.message(channel, seq & 0xFFFFFFFF, stamp, data)
        except OSError as error:
            self._cut_short(error)

    def complete(self) -> None:
        """Write the last chunk and the index; `add` may go on after that. Raises FollowspotError as `add`."""
        if self._broken or self._complete:
            return
        self._require_file()
        try:
            self._writer.finish()
            self._complete = True
        except OSError as error:
            self._cut_short(error)

    def close(self) -> None:
        """Complete the file, and close it. Raises FollowspotError, if nothing was cut short before."""
        try:
            self.complete()
        finally:
            self._close_file()

    def _close_file(self) -> None:
        try:
            self._file.close()
        except OSError as error:
            if not self._broken:
                self._cut_short(error)

    def _resume(self) -> None:
        if self._complete:
            self._complete = False
            self._writer.resume()

    def _require_file(self) -> None:
        """Raises FollowspotError if the file was removed."""
        if removed(self._file.fileno()):
            self._broken = True
            raise FollowspotError(f"{self.path} was removed while it was recorded")

    def _cut_short(self, error: OSError) -> NoReturn:
        self._broken = True
        remedy = limit_remedy(error, "free space on the disk or record fewer ports")
        raise FollowspotError(f"{self.path} is cut short: {error.strerror}\n    {remedy}") from None

    def _register(self, topic: str, encoding: str, schema: Schema) -> int:
        if schema.name not in self._schemas:
            number = self._writer.schema(schema.name, schema.encoding, schema.text.encode())
            self._schemas[schema.name] = number
        channel = self._writer.channel(topic, encoding, self._schemas[schema.name])
        self._channels[topic] = channel
        return channel


_open: dict[Path, Recorder] = {}
"""The files that sinks of this process have open."""


def join(path: Path, chunking: Chunking) -> Recorder:
    """The recorder of this file, shared by all sinks that have joined it. Raises FollowspotError.

    If the file exists, the recording goes to a new one beside it, with a number in its name.
    """
    recorder = _open.get(path)
    if recorder is None:
        recorder = _open[path] = Recorder(unused_path(path), chunking)
    recorder.users += 1
    return recorder


def leave(path: Path, recorder: Recorder) -> None:
    """The last one closes the file. Raises FollowspotError."""
    recorder.users -= 1
    if recorder.users == 0:
        _open.pop(path, None)
        recorder.close()
