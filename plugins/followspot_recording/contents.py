"""The contents of an MCAP file: from its index if that is whole, else from its records in turn."""

from __future__ import annotations

import zlib
from contextlib import suppress
from dataclasses import dataclass
from typing import IO

from mcap import records
from mcap.opcode import Opcode

from followspot.errors import FollowspotError
from followspot_recording.records import (
    HEAD,
    MAGIC,
    MAX_CHUNK,
    MAX_RECORD,
    ChunkSpan,
    Contents,
    Damaged,
    Definitions,
    Span,
    parse,
    read_chunk,
    read_span,
)

_FOOTER = Span(0, HEAD.size + 20)
_UNCHUNKED = "it has messages outside of chunks (mcap compress FILE -o NEW.mcap puts them into chunks)"
"""Any writer of MCAP may leave out chunks; their checksums are what tells damaged messages."""
_MAX_ITEMS = 1 << 22
"""Most records that one file is read for."""


def read_contents(file: IO[bytes], name: str) -> Contents:
    """The undamaged contents of the file. Raises FollowspotError if it is no MCAP file."""
    file.seek(0, 2)
    size = file.tell()
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        raise FollowspotError(f"{name} is no recording: it does not begin like an MCAP file")
    try:
        found = _from_index(file, size)
    except Damaged:
        found = None
    return found or _from_records(file, size)


def _from_index(file: IO[bytes], size: int) -> Contents | None:
    """From the summary at the end; None if there is none that names all contents. Raises Damaged."""
    end = size - len(MAGIC) - _FOOTER.length
    if end < len(MAGIC):
        return None
    footer: records.Footer = parse(records.Footer, read_span(file, Span(end, _FOOTER.length), Opcode.FOOTER))
    start = footer.summary_start
    if not len(MAGIC) <= start < end or end - start > MAX_CHUNK or file.read() != MAGIC:
        return None
    file.seek(start)
    summary = file.read(end - start + _FOOTER.length - 4)
    if footer.summary_crc and zlib.crc32(summary) != footer.summary_crc:
        raise Damaged("the checksum of the index is wrong")
    reading = _Index(Contents(summary=start), Definitions(), start)
    offset = 0
    while offset + HEAD.size <= end - start:
        opcode, length = HEAD.unpack_from(summary, offset)
        offset += HEAD.size
        reading.take(opcode, summary[offset : offset + length])
        offset += length
    found = reading.contents
    found.channels.update(reading.definitions.channels)
    found.chunks.sort(key=lambda chunk: chunk.offset)
    return found if reading.is_complete() else None


@dataclass
class _Index:
    """Reads the records of a summary. end: of the data, B; messages: their number, None if it is not told."""

    contents: Contents
    definitions: Definitions
    end: int
    messages: int | None = None

    def is_complete(self) -> bool:
        """Whether it names all chunks, and the channels of each: other programs may leave them out."""
        found = self.contents
        if not found.chunks:
            return self.messages == 0
        return all(chunk.channels and chunk.channels <= found.channels.keys() for chunk in found.chunks)

    def take(self, opcode: int, body: bytes) -> None:
        """One record. Raises Damaged."""
        if self.definitions.take(opcode, body):
            return
        if opcode == Opcode.CHUNK_INDEX:
            chunk: records.ChunkIndex = parse(records.ChunkIndex, body)
            span = self._inside(chunk.chunk_start_offset, chunk.chunk_length, MAX_CHUNK)
            times = chunk.message_start_time, chunk.message_end_time
            channels = frozenset(chunk.message_index_offsets)
            self.contents.chunks.append(ChunkSpan(span.offset, span.length, *times, channels))
        elif opcode == Opcode.ATTACHMENT_INDEX:
            attached: records.AttachmentIndex = parse(records.AttachmentIndex, body)
            self.contents.attachments[attached.name] = self._inside(attached.offset, attached.length)
        elif opcode == Opcode.METADATA_INDEX:
            fact: records.MetadataIndex = parse(records.MetadataIndex, body)
            self.contents.metadata[fact.name] = self._inside(fact.offset, fact.length)
        elif opcode == Opcode.STATISTICS:
            statistics: records.Statistics = parse(records.Statistics, body)
            self.messages = statistics.message_count

    def _inside(self, offset: int, length: int, most: int = MAX_RECORD) -> Span:
        if length > most or offset + length > self.end:
            raise Damaged(f"the index speaks of {length} bytes at {offset}")
        return Span(offset, length)


def _from_records(file: IO[bytes], size: int) -> Contents:
    """The contents from all records up to the first damaged one, whose position they state."""
    scan = _Scan(file, Contents(), Definitions())
    offset = len(MAGIC)
    try:
        for _ in range(_MAX_ITEMS):
            if offset == size:
                raise Damaged("the recording was not finished")
            file.seek(offset)
            head = file.read(HEAD.size)
            if len(head) < HEAD.size:
                raise Damaged("the file is cut off within a record")
            opcode, length = HEAD.unpack(head)
            if opcode == Opcode.DATA_END:
                told = _told_messages(file, offset + HEAD.size + length, size)
                scan.contents.problem = f"its index is damaged or incomplete; {scan.compared(told)}"
                break
            if offset + HEAD.size + length > size:
                raise Damaged("the file is cut off or damaged")
            scan.take(opcode, Span(offset, HEAD.size + length))
            offset += HEAD.size + length
    except Damaged as error:
        scan.contents.problem = f"{error} at byte {offset} of {size}; read up to there"
    scan.contents.channels.update(scan.definitions.channels)
    return scan.contents


def _told_messages(file: IO[bytes], offset: int, size: int) -> int | None:
    """The number of messages by the statistics behind the data; None if these cannot be read."""
    for _ in range(_MAX_ITEMS):
        file.seek(offset)
        head = file.read(HEAD.size)
        if len(head) < HEAD.size:
            break
        opcode, length = HEAD.unpack(head)
        span = Span(offset, HEAD.size + length)
        offset += span.length
        if offset > size:
            break
        if opcode == Opcode.STATISTICS:
            with suppress(Damaged):
                found: records.Statistics = parse(
                    records.Statistics, read_span(file, span, Opcode.STATISTICS)
                )
                return found.message_count
    return None


@dataclass
class _Scan:
    """Reads the records of the data section, and counts the messages."""

    file: IO[bytes]
    contents: Contents
    definitions: Definitions
    messages: int = 0

    def compared(self, told: int | None) -> str:
        """Whether the messages are as many as the statistics tell: a chunk may be missing, or there twice."""
        if told is None or told == self.messages:
            return "the messages are whole"
        return f"the {self.messages} messages in the file are not those that it tells of, {told}"

    def take(self, opcode: int, span: Span) -> None:
        """One record. Raises Damaged."""
        if opcode == Opcode.CHUNK:
            self._chunk(span)
        elif opcode == Opcode.ATTACHMENT:
            data: records.Attachment = parse(
                records.Attachment, read_span(self.file, span, Opcode.ATTACHMENT)
            )
            self.contents.attachments[data.name] = span
        elif opcode == Opcode.METADATA:
            fact: records.Metadata = parse(records.Metadata, read_span(self.file, span, Opcode.METADATA))
            self.contents.metadata[fact.name] = span
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            self.definitions.take(opcode, read_span(self.file, span, Opcode(opcode)))
        elif opcode == Opcode.MESSAGE:
            raise Damaged(_UNCHUNKED)
        elif opcode not in (Opcode.HEADER, Opcode.MESSAGE_INDEX) and opcode < 0x80:
            raise Damaged(f"record {opcode} does not belong")

    def _chunk(self, span: Span) -> None:
        """Add a chunk with its channels. Raises Damaged, also if the chunk is cut off."""
        chunk = read_chunk(self.file, span, self.definitions)
        times = [message.time for found in chunk.messages.values() for message in found]
        self.messages += len(times)
        begin, end = min(times, default=0), max(times, default=0)
        self.contents.chunks.append(
            ChunkSpan(span.offset, span.length, begin, end, frozenset(chunk.messages))
        )
