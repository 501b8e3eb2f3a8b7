"""The records of an MCAP file, checked: invalid ones raise `Damaged`."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from typing import IO, Any, NamedTuple

import lz4.frame
import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from followspot.errors import FollowspotError
from followspot.wire import MAX_PACKED

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
"""Head of every record: its type, and the number of bytes that follow."""
MAX_CHUNK = MAX_PACKED + (64 << 20)
"""Largest chunk, bytes, before and after compression: the largest message and those before it."""
MAX_FILE = 1 << 62
"""Beyond the end of any file."""
MAX_RECORD = 64 << 20
"""Largest other record, bytes."""
_MESSAGE = struct.Struct("<HIQQ")
_DATA_END = HEAD.size + 4
_PIECE = 1 << 20


class Damaged(FollowspotError):
    """Bytes that are no valid record of an MCAP file; the text says why."""


@dataclass(frozen=True)
class Channel:
    """One topic. schema: its name; contract: its text."""

    number: int
    topic: str
    encoding: str
    schema: str
    contract: str


@dataclass(frozen=True)
class Span:
    """The position of a record, in bytes."""

    offset: int
    length: int


@dataclass(frozen=True)
class ChunkSpan(Span):
    """The position of a chunk; begin, end: its capture times, ns; channels: those with messages in it."""

    begin: int
    end: int
    channels: frozenset[int]


@dataclass
class Contents:
    """The contents of a file.

    problem: why and at which byte it ends early, empty if it is whole; good: byte up to which chunks are
    known to be good; summary: byte at which the index begins that was read, 0 if there is none.
    """

    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkSpan] = field(default_factory=list)
    attachments: dict[str, Span] = field(default_factory=dict)
    metadata: dict[str, Span] = field(default_factory=dict)
    problem: str = ""
    good: int = MAX_FILE
    summary: int = 0


class Recorded(NamedTuple):
    """One message as it stands in the file; time: ns."""

    time: int
    seq: int
    data: memoryview


@dataclass(frozen=True)
class Chunk:
    """A chunk that was decompressed and is whole."""

    size: int
    messages: Mapping[int, list[Recorded]]


def parse(kind: Any, data: bytes | memoryview) -> Any:
    """A record of `mcap.records` from its bytes. Raises Damaged."""
    try:
        return kind.read(ReadDataStream(BytesIO(data)))
    except (McapError, struct.error, ValueError, MemoryError, OverflowError) as error:
        raise Damaged(f"no {kind.__name__}: {type(error).__name__}") from None


def read_span(file: IO[bytes], span: Span, opcode: Opcode, most: int = MAX_RECORD) -> bytes:
    """The bytes of the record that lies there, without its head. Raises Damaged."""
    if not HEAD.size <= span.length <= most:
        raise Damaged(f"a record of {span.length} bytes, at most {most} allowed")
    file.seek(span.offset)
    data = file.read(span.length)
    if len(data) != span.length or HEAD.unpack_from(data) != (opcode, span.length - HEAD.size):
        raise Damaged(f"no {opcode.name.lower()} at byte {span.offset}")
    return data[HEAD.size :]


def read_attachment(file: IO[bytes], span: Span) -> bytes:
    """The data of an attachment. Raises Damaged."""
    data = read_span(file, span, Opcode.ATTACHMENT)
    if zlib.crc32(data[:-4]) != int.from_bytes(data[-4:], "little"):
        raise Damaged("the checksum of an attachment is wrong")
    attachment: records.Attachment = parse(records.Attachment, data)
    return attachment.data


def check_data(file: IO[bytes], summary: int) -> None:
    """Compare all bytes before the index with their checksum, if the file has one. Raises Damaged.

    summary: byte at which the index begins. Facts, and indices of messages, have no other checksum.
    """
    end = summary - _DATA_END
    told: records.DataEnd = parse(records.DataEnd, read_span(file, Span(end, _DATA_END), Opcode.DATA_END))
    file.seek(0)
    checksum = 0
    for start in range(0, end, _PIECE):
        checksum = zlib.crc32(file.read(min(_PIECE, end - start)), checksum)
    if told.data_section_crc not in (0, checksum):
        raise Damaged("the checksum of all data is wrong: facts about the run may be, too")


def read_chunk(file: IO[bytes], span: Span, definitions: Definitions | None = None) -> Chunk:
    """The chunk that lies there. Raises Damaged.

    definitions: of what lies before it, for its channels may have schemas from there; gets its own as well.
    """
    data = read_span(file, span, Opcode.CHUNK, MAX_CHUNK)
    chunk: records.Chunk = parse(records.Chunk, data)
    if chunk.uncompressed_size > MAX_CHUNK:
        raise Damaged(f"a chunk of {chunk.uncompressed_size} bytes, at most {MAX_CHUNK} allowed")
    plain = _decompressed(chunk)
    if len(plain) != chunk.uncompressed_size or (
        chunk.uncompressed_crc and zlib.crc32(plain) != chunk.uncompressed_crc
    ):
        raise Damaged("the checksum of a chunk is wrong")
    messages: dict[int, list[Recorded]] = {}
    definitions = Definitions() if definitions is None else definitions
    for opcode, body in _walk(memoryview(plain)):
        if opcode == Opcode.MESSAGE and len(body) >= _MESSAGE.size:
            number, seq, time, _ = _MESSAGE.unpack_from(body)
            messages.setdefault(number, []).append(Recorded(time, seq, body[_MESSAGE.size :]))
        else:
            definitions.take(opcode, body)
    return Chunk(len(plain), messages)


class Definitions:
    """Collects channels, whose schemas precede them."""

    def __init__(self) -> None:
        self.channels: dict[int, Channel] = {}
        self._schemas: dict[int, records.Schema] = {}

    def take(self, opcode: int, body: bytes | memoryview) -> bool:
        """Whether it was a schema or a channel. Raises Damaged."""
        if opcode == Opcode.SCHEMA:
            schema: records.Schema = parse(records.Schema, body)
            self._schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            found: records.Channel = parse(records.Channel, body)
            known = self._schemas.get(found.schema_id)
            name, text = (known.name, known.data.decode(errors="replace")) if known else ("", "")
            self.channels[found.id] = Channel(found.id, found.topic, found.message_encoding, name, text)
        return opcode in (Opcode.SCHEMA, Opcode.CHANNEL)


def _walk(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """The records that lie one after the other in these bytes. Raises Damaged."""
    start = 0
    while start < len(data):
        if start + HEAD.size > len(data):
            raise Damaged("a chunk ends within a record")
        opcode, length = HEAD.unpack_from(data, start)
        start += HEAD.size
        if start + length > len(data):
            raise Damaged("a chunk ends within a record")
        yield opcode, data[start : start + length]
        start += length


def _decompressed(chunk: records.Chunk) -> bytes:
    """The decompressed bytes of a chunk, never more than it states. Raises Damaged."""
    size = chunk.uncompressed_size
    try:
        if chunk.compression == "lz4":
            plain: bytes = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
            return plain
        if chunk.compression == "zstd":
            with zstandard.ZstdDecompressor().stream_reader(chunk.data) as reader:
                return reader.read(size + 1)
    except (RuntimeError, zstandard.ZstdError, ValueError, MemoryError, EOFError) as error:
        raise Damaged(f"a chunk cannot be decompressed: {error}") from None
    if chunk.compression:
        raise Damaged(f"a chunk is compressed with {chunk.compression[:20]!r}; known: lz4, zstd")
    return chunk.data
