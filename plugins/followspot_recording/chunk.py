"""A chunk of an MCAP file while it is gathered."""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Sequence
from struct import Struct

from mcap.opcode import Opcode

from followspot_recording.records import HEAD

_MESSAGE = Struct("<BQHIQQ")
_CHUNK = Struct("<BQQQQII")
_LENGTH = Struct("<Q")
_INDEX = Struct("<BQHI")


class ChunkBuilder:
    """Gathers records without copying them. size: bytes so far; count: messages among them."""

    def __init__(self) -> None:
        self.size = self.count = 0
        self.begin, self.end = 0, 0
        self.parts: list[bytes] = []
        self.index: dict[int, array[int]] = {}
        """Time and offset of each message, in turn, by channel."""

    def define(self, record: bytes) -> None:
        """Add a schema or a channel."""
        self.parts.append(record)
        self.size += len(record)

    def message(self, channel: int, seq: int, time: int, data: bytes) -> None:
        """Add a message; time: ns."""
        self.index.setdefault(channel, array("Q")).extend((time, self.size))
        length = _MESSAGE.size - HEAD.size + len(data)
        self.parts += _MESSAGE.pack(Opcode.MESSAGE, length, channel, seq, time, time), data
        self.size += _MESSAGE.size + len(data)
        self.begin = min(self.begin, time) if self.count else time
        self.end = max(self.end, time)
        self.count += 1

    def head(self, compression: str, size: int) -> bytes:
        """The chunk's record up to its content, which has this size in the file."""
        name = compression.encode()
        length = _CHUNK.size - HEAD.size + len(name) + _LENGTH.size + size
        fields = self.begin, self.end, self.size, self._checksum(), len(name)
        return _CHUNK.pack(Opcode.CHUNK, length, *fields) + name + _LENGTH.pack(size)

    def indices(self) -> Sequence[tuple[int, bytes]]:
        """Channel and record of each message index."""
        return [(channel, _message_index(channel, entries)) for channel, entries in self.index.items()]

    def _checksum(self) -> int:
        found = 0
        for part in self.parts:
            found = zlib.crc32(part, found)
        return found


def _message_index(channel: int, entries: array[int]) -> bytes:
    data = entries.tobytes()
    return _INDEX.pack(Opcode.MESSAGE_INDEX, _INDEX.size - HEAD.size + len(data), channel, len(data)) + data
