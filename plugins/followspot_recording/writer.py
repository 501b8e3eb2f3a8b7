"""MCAP files, written chunk by chunk (the format as mcap.dev specifies it).

Like the writer of the mcap package, but made for pictures: messages are not copied before they are
compressed, chunks that would not become smaller are not compressed, and of what is in the file only a few
packed bytes a chunk stay in memory, for the index at its end.
"""

from __future__ import annotations

import zlib
from typing import IO, Any

import lz4.frame
import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder

from followspot_recording.chunk import ChunkBuilder
from followspot_recording.records import HEAD, MAGIC

_ZSTD_LEVEL = 1
"""The fastest one that still codes noise with fewer bits; level 3 takes twice the time for a twentieth."""


def _zstd(data: bytes) -> bytes:
    return zstandard.compress(data, _ZSTD_LEVEL)


_COMPRESS: dict[str, Any] = {"lz4": lz4.frame.compress, "zstd": _zstd}
_WORTHWHILE = 0.95
"""A chunk that compression leaves larger than this share of it is noise, and so will be those after it."""
_PAUSE = 15
"""How many of those are not compressed."""
_FOOTER_FIELDS = 16


class McapWriter:
    """Writes to a file that is open for writing; every method raises OSError if that fails."""

    def __init__(self, file: IO[bytes], compression: str, *, profile: str) -> None:
        """compression: "lz4", "zstd" or "none"."""
        self._file = file
        self._compression = compression
        self._pause = 0
        self._offset = self._checksum = 0
        self._whole = 0, 0
        """Offset of the end section that `finish` wrote, B, and the checksum of all before it."""
        self._definitions: list[bytes] = []
        self._indices: list[bytes] = []
        self._statistics = records.Statistics(0, 0, {}, 0, 0, 0, 0, 0, 0)
        self.chunk = ChunkBuilder()
        self._put(MAGIC, _packed(records.Header(library="followspot", profile=profile)))

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Embed a file."""
        record = _packed(records.Attachment(0, 0, name, media_type, data))
        index = records.AttachmentIndex(self._offset, len(record), 0, 0, len(data), name, media_type)
        self._indices.append(_packed(index))
        self._statistics.attachment_count += 1
        self._put(record)

    def describe(self, name: str, facts: dict[str, str]) -> None:
        """Embed texts by name."""
        record = _packed(records.Metadata(name=name, metadata=facts))
        index = records.MetadataIndex(offset=self._offset, length=len(record), name=name)
        self._indices.append(_packed(index))
        self._statistics.metadata_count += 1
        self._put(record)

    def schema(self, name: str, encoding: str, data: bytes) -> int:
        """Number of a new schema."""
        self._statistics.schema_count += 1
        number = self._statistics.schema_count
        self._define(records.Schema(id=number, name=name, encoding=encoding, data=data))
        return number

    def channel(self, topic: str, encoding: str, schema: int) -> int:
        """Number of a new channel."""
        self._statistics.channel_count += 1
        number = self._statistics.channel_count
        self._statistics.channel_message_counts[number] = 0
        self._define(records.Channel(number, topic, encoding, {}, schema))
        return number

    def flush(self) -> None:
        """Write the collected messages as one chunk with its index."""
        chunk, start = self.chunk, self._offset
        if not chunk.count:
            return
        compression, parts = self._compressed(chunk)
        size = sum(map(len, parts))
        self._put(chunk.head(compression, size), *parts)
        length = self._offset - start
        offsets = {}
        for channel, index in chunk.indices():
            offsets[channel] = self._offset
            self._put(index)
        self._file.flush()
        indices = self._offset - start - length
        told = (chunk.end, indices, offsets, chunk.begin, chunk.size)
        self._indices.append(_packed(records.ChunkIndex(length, start, compression, size, *told)))
        self._count(chunk)
        self.chunk = ChunkBuilder()

    def finish(self) -> None:
        """Write the last chunk, the index of all, and the end."""
        self.flush()
        self._whole = self._offset, self._checksum
        self._put(_packed(records.DataEnd(self._checksum)))
        summary = [*self._definitions, _packed(self._statistics), *self._indices]
        start = self._offset
        self._put(*summary)
        footer = _packed(records.Footer(summary_offset_start=0, summary_start=start, summary_crc=0))
        checksum = 0
        for part in (*summary, footer[: HEAD.size + _FOOTER_FIELDS]):
            checksum = zlib.crc32(part, checksum)
        self._put(footer[: HEAD.size + _FOOTER_FIELDS], checksum.to_bytes(4, "little"), MAGIC)
        self._file.flush()

    def resume(self) -> None:
        """Go on after `finish`: the file loses its index and its end until `finish` is called again."""
        self._offset, self._checksum = self._whole
        self._file.seek(self._offset)
        self._file.truncate()

    def _compressed(self, chunk: ChunkBuilder) -> tuple[str, list[bytes]]:
        """A chunk's content as it is stored, and its compression."""
        compress = _COMPRESS.get(self._compression)
        self._pause = max(0, self._pause - 1)
        if compress is None or self._pause:
            return "", chunk.parts
        smaller: bytes = compress(b"".join(chunk.parts))
        if len(smaller) > _WORTHWHILE * chunk.size:
            self._pause = _PAUSE + 1
        return self._compression, [smaller]

    def _count(self, chunk: ChunkBuilder) -> None:
        total = self._statistics
        total.message_start_time = (
            min(total.message_start_time, chunk.begin) if total.chunk_count else chunk.begin
        )
        total.message_end_time = max(total.message_end_time, chunk.end)
        total.message_count += chunk.count
        total.chunk_count += 1
        for channel, entries in chunk.index.items():
            total.channel_message_counts[channel] += len(entries) // 2

    def _define(self, record: records.Schema | records.Channel) -> None:
        """Add a definition to the chunk and to the index."""
        data = _packed(record)
        self._definitions.append(data)
        self.chunk.define(data)

    def _put(self, *parts: bytes) -> None:
        for part in parts:
            self._file.write(part)
            self._offset += len(part)
            self._checksum = zlib.crc32(part, self._checksum)


def _packed(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data
