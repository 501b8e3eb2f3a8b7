"""Completeness of a video file: the size that its container declares against its actual size.

A recording that was cut off still opens and plays up to the cut; only the container remembers the rest.
"""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from followspot.files import open_regular

EBML = b"\x1a\x45\xdf\xa3"
SEGMENT = b"\x18\x53\x80\x67"
MOST_BOXES = 10_000


def cut_off(path: Path) -> str:
    """' (the file is cut off: 300 of 500 bytes)' for a file shorter than it declares; else ''."""
    try:
        with open_regular(path, None) as file:
            declared = declared_size(file)
        actual = path.stat().st_size
    except OSError:
        return ""
    return f" (the file is cut off: {actual} of {declared} bytes)" if declared > actual else ""


def is_matroska(path: Path) -> bool:
    """Whether a file is Matroska or WebM, whose containers do not count their frames."""
    try:
        with open_regular(path, None) as file:
            return file.read(4) == EBML
    except OSError:
        return False


def declared_size(file: BinaryIO) -> int:
    """Bytes that the file should have, after its own header (Matroska, AVI, MP4); 0 if it does not say."""
    head = file.read(12)
    file.seek(0)
    if head[:4] == EBML:
        return _matroska(file)
    if head[:4] == b"RIFF":
        return 8 + int.from_bytes(head[4:8], "little")
    if head[4:8] == b"ftyp":
        return _mp4(file)
    return 0


def _matroska(file: BinaryIO) -> int:
    """An EBML header element, then the segment; each is an id, a size and its content (RFC 8794)."""
    file.seek(4)
    file.seek(variable_integer(file), 1)
    if file.read(4) != SEGMENT:
        return 0
    size = variable_integer(file)
    return file.tell() + size if size else 0


def variable_integer(file: BinaryIO) -> int:
    """RFC 8794, section 4; 0 for the reserved size "unknown", which streams have."""
    first = file.read(1)
    if not first or not first[0]:
        return 0
    length = 9 - first[0].bit_length()
    value = int.from_bytes(first + file.read(length - 1), "big") & ((1 << 7 * length) - 1)
    return 0 if value == (1 << 7 * length) - 1 else value


def _mp4(file: BinaryIO) -> int:
    """Boxes one after another, each led by its size (ISO 14496-12); 1 means a 64-bit size, 0 to the end."""
    end = 0
    for _ in range(MOST_BOXES):
        file.seek(end)
        head = file.read(16)
        size = int.from_bytes(head[:4], "big")
        if size == 1:
            size = int.from_bytes(head[8:16], "big")
        if len(head) < 8 or size < 8:
            break
        end += size
    return end
