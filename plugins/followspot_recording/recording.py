"""A recording to read: its ports, facts about the run, and the messages of each port in order."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path

from mcap import records
from mcap.opcode import Opcode

from followspot.closing import Closing
from followspot.errors import FollowspotError
from followspot.files import open_regular
from followspot.messages import InvalidMessage
from followspot.ports.firing import is_firings
from followspot.wire import restored
from followspot_recording.contents import read_contents
from followspot_recording.records import (
    Channel,
    Chunk,
    ChunkSpan,
    Contents,
    Damaged,
    Recorded,
    check_data,
    parse,
    read_attachment,
    read_chunk,
    read_span,
)
from followspot_recording.topics import ENCODING, port_of

CACHED = 64 << 20
"""Bytes of chunks that are kept for the other ports of a process, which read the same ones."""
_File = tuple[str, int, int]
"""Path, time of the last change, size."""


class Recording(Closing):
    """An open MCAP file. `problem` states why and at which byte it ends early; empty if it is whole."""

    def __init__(self, path: str | Path) -> None:
        """Open the file and list its contents. Raises FollowspotError."""
        self.path = Path(path)
        try:
            self._file = open_regular(self.path, None)
        except OSError as error:
            raise FollowspotError(f"{path} cannot be read: {error.strerror}") from None
        about = os.fstat(self._file.fileno())
        self._key = str(self.path.absolute()), about.st_mtime_ns, about.st_size
        try:
            self._contents = _known.get(self._key) or read_contents(self._file, str(path))
        except FollowspotError:
            self._file.close()
            raise
        _known.clear()
        _known[self._key] = self._contents

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    @property
    def problem(self) -> str:
        """Why it is not whole, as far as is known by now."""
        return f"{self.path}: {self._contents.problem}" if self._contents.problem else ""

    @cached_property
    def ports(self) -> Mapping[str, Channel]:
        """The exactly recorded ports, STAGE.PORT, in the order in which they first spoke."""
        return {port: channel for port, channel in self._exact.items() if not is_firings(port)}

    @cached_property
    def firings(self) -> tuple[str, ...]:
        """Names of the channels with the firings of stages, as `firings_of` makes them."""
        return tuple(filter(is_firings, self._exact))

    @cached_property
    def _exact(self) -> Mapping[str, Channel]:
        """The exact messages, by port, and the firings of stages."""
        return {
            port: channel
            for channel in sorted(self._contents.channels.values(), key=lambda channel: channel.number)
            if channel.encoding == ENCODING and (port := port_of(channel.topic)) is not None
        }

    @property
    def begin(self) -> int:
        """Earliest capture time, ns; 0 if there is none."""
        return min((chunk.begin for chunk in self._contents.chunks), default=0)

    @property
    def end(self) -> int:
        """Latest capture time, ns; 0 if there is none."""
        return max((chunk.end for chunk in self._contents.chunks), default=0)

    @cached_property
    def metadata(self) -> Mapping[str, str]:
        """The facts about the run. Raises Damaged."""
        span = self._contents.metadata.get("followspot")
        if span is None:
            return {}
        found: records.Metadata = parse(records.Metadata, read_span(self._file, span, Opcode.METADATA))
        return found.metadata

    @property
    def attachments(self) -> tuple[str, ...]:
        """Names of the embedded files."""
        return tuple(self._contents.attachments)

    def attachment(self, name: str) -> bytes:
        """An embedded file. Raises FollowspotError if there is none, or it is damaged."""
        span = self._contents.attachments.get(name)
        if span is None:
            raise FollowspotError(f"{self.path} holds no {name}: it was not made by followspot run --record")
        try:
            return read_attachment(self._file, span)
        except Damaged as error:
            raise FollowspotError(f"{self.path}: {name} is damaged: {error}") from None

    def messages(self, port: str, start: int = 0, stop: int | None = None) -> Iterator[Recorded]:
        """The messages of a port from `start` up to and with `stop`, ns, in order.

        They end at the first damage, which `problem` then states.
        """
        channel = self._exact.get(port)
        if channel is None:
            return
        for span in self._contents.chunks:
            outside = span.end < start or (stop is not None and span.begin > stop)
            if outside or channel.number not in span.channels:
                continue
            chunk = self._chunk(span)
            if chunk is None:
                return
            for message in chunk.messages.get(channel.number, ()):
                if message.time >= start and (stop is None or message.time <= stop):
                    yield message._replace(data=_restored(message.data))

    def examine(self) -> None:
        """Read the whole file, so that `problem` says for certain whether it is whole."""
        contents = self._contents
        if all(self._chunk(span) is not None for span in contents.chunks) and not contents.problem:
            try:
                check_data(self._file, contents.summary)
            except Damaged as error:
                contents.problem = str(error)

    def _chunk(self, span: ChunkSpan) -> Chunk | None:
        """The chunk, None if it or one before it is damaged."""
        contents = self._contents
        if span.offset < contents.good:
            try:
                return _last_chunks.chunk((self._key, span.offset), self, span)
            except Damaged as error:
                size = self._key[2]
                contents.good = span.offset
                contents.problem = f"{error} at byte {span.offset} of {size}; read up to there"
        return None

    def read(self, span: ChunkSpan) -> Chunk:
        """The chunk from the file. Raises Damaged."""
        return read_chunk(self._file, span)


def _restored(data: memoryview) -> memoryview:
    """The packed message as it was sent. Malformed bytes stay: unpacking them fails, and says why."""
    try:
        return memoryview(restored(data))
    except InvalidMessage:
        return data


_known: dict[_File, Contents] = {}
"""The contents of the recording that was opened last; they take long to find without an index."""


class _LastChunks:
    """The chunks that were read last, for all recordings of this process: as many as `CACHED` holds."""

    def __init__(self) -> None:
        self._chunks: OrderedDict[tuple[_File, int], Chunk] = OrderedDict()
        self._size = 0

    def chunk(self, key: tuple[_File, int], recording: Recording, span: ChunkSpan) -> Chunk:
        """The chunk, from the file if it is none of the last. Raises Damaged."""
        chunk = self._chunks.get(key)
        if chunk is None:
            chunk = recording.read(span)
            self._size += chunk.size if key not in self._chunks else 0  # another thread was faster
            self._chunks[key] = chunk
            while len(self._chunks) > 1 and self._size > CACHED:
                self._size -= self._chunks.popitem(last=False)[1].size
        else:
            self._chunks.move_to_end(key)
        return chunk


_last_chunks = _LastChunks()
