"""Checksums of a Matroska file: FFmpeg stores one with each cluster, some pictures or seconds of the video.

A decoder shows a damaged picture as well as it can and reports no error: FFV1 without checksums of its own
decodes any bits. The checksums of the file show the damage. MP4 and AVI have none.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

from followspot.closing import Closing
from followspot.files import open_regular
from followspot_cameras.video.container import EBML, SEGMENT, variable_integer

CLUSTER = b"\x1f\x43\xb6\x75"
_INFO = b"\x15\x49\xa9\x66"
_OTHERS = frozenset(
    bytes.fromhex(kind) for kind in ("114d9b74", "1654ae6b", "1c53bb6b", "1941a469", "1043a770", "1254c367")
)
"""Other elements of a segment: seek head, tracks, cues, attachments, chapters, tags."""
_SHORT = (0xBF, 0xEC)
"""Elements whose id has one byte: a checksum, void."""
_SCALE = b"\x2a\xd7\xb1\x83"
"""TimestampScale, of three bytes as FFmpeg writes it."""
_CHECKSUM = b"\xbf\x84"
_TIMESTAMP = b"\xe7"
_MOST_INFO = 10_000
_CHUNK = 1 << 20


@dataclass(frozen=True)
class Cluster:
    """A cluster with a checksum. time: of its first picture in the file, s; start, size: of what the checksum
    covers, bytes.
    """

    time: float
    start: int
    size: int
    checksum: int


class Checksums(Closing):
    """Compares the clusters of a video with their checksums while it plays. Raises OSError."""

    def __init__(self, path: Path) -> None:
        self._file = open_regular(path, None)
        self._clusters = clusters(self._file)
        self._next = next(self._clusters, None)

    def damaged(self, until: float) -> Iterator[float]:
        """Times of the clusters that begin by `until`, were not asked for before and are damaged; s."""
        while self._next is not None and self._next.time <= until:
            cluster = self._next
            if not _matches(self._file, cluster):
                yield cluster.time
            self._next = next(self._clusters, None)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def clusters(file: BinaryIO) -> Iterator[Cluster]:
    """The clusters of a Matroska file that have checksums; none of another file (RFC 8794, RFC 9559).

    If damage hides where the next cluster begins, the last one comes again, with a checksum that no data has.
    """
    file.seek(0)
    if file.read(4) != EBML:
        return
    file.seek(variable_integer(file), 1)
    if file.read(4) != SEGMENT:
        return
    size = variable_integer(file)
    start = file.tell()
    scale, last = 1e-3, None
    while not size or file.tell() < start + size:
        kind = file.read(4)
        if kind and kind[0] in _SHORT:
            file.seek(1 - len(kind), 1)
        elif kind not in (CLUSTER, _INFO, *_OTHERS):
            if len(kind) == 4 and last is not None:
                yield replace(last, size=0, checksum=-1)
            return
        length = variable_integer(file)
        if not length:  # unknown, as in live streams
            return
        content = file.tell()
        if kind == CLUSTER and (last := _cluster(file, length, scale)) is not None:
            yield last
        if kind == _INFO:
            scale = _scale(file.read(min(length, _MOST_INFO)))
        file.seek(content + length)


def _cluster(file: BinaryIO, length: int, scale: float) -> Cluster | None:
    """The cluster whose content begins here; None if it has no checksum."""
    head = file.read(6)
    if head[:2] != _CHECKSUM or length < 6:
        return None
    start = file.tell()
    time = variable_integer(file) if file.read(1) == _TIMESTAMP else 0
    time = int.from_bytes(file.read(time), "big") if 0 < time <= 8 else 0
    return Cluster(time * scale, start, length - 6, int.from_bytes(head[2:], "little"))


def _scale(info: bytes) -> float:
    """Seconds of a unit of time stamps."""
    _, found, rest = info.partition(_SCALE)
    return int.from_bytes(rest[:3], "big") / 1e9 if found else 1e-3


def _matches(file: BinaryIO, cluster: Cluster) -> bool:
    """Whether a cluster has its CRC-32. One that the end of the file cuts off counts as whole."""
    file.seek(cluster.start)
    left, checksum = cluster.size, 0
    while left:
        chunk = file.read(min(left, _CHUNK))
        if not chunk:
            return True
        checksum = zlib.crc32(chunk, checksum)
        left -= len(chunk)
    return checksum == cluster.checksum
