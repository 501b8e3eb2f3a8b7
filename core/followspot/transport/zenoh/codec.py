"""Compression of messages between hosts: lossless, or as JPEG if the edge allows it (docs/wire.md).

The second byte of a token says which. OpenCV is imported only if pictures are coded.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from math import prod
from struct import Struct
from typing import Any

import numpy as np

from followspot.graph.plan import EdgeCodec
from followspot.messages import MAX_BYTES, Array, InvalidMessage, Message
from followspot.transport.codec import MAX_PACKED, codec_of, pack, unpack
from followspot.transport.token import Watermark
from followspot.transport.wire import ALIGN, RAW, aligned, padded, unpack_head

LOSSLESS, JPEG = 1, 2
"""Second byte of what is coded: PNG for pictures and zlib for the rest; JPEG for pictures, zlib else."""
_CODES: dict[EdgeCodec, int] = {"raw": RAW, "lossless": LOSSLESS, "jpeg": JPEG}
_SIZE = Struct("<Q")
_JPEG_QUALITY = 90
_FAST = 1
"""Level of compression, of nine: speed matters more than the last per cent."""
_PNG = b"\x89PNG\r\n\x1a\n"


def pack_as(token: Message | Watermark, codec: EdgeCodec) -> bytes:
    """Pack a token like `followspot.transport.codec.pack`, with every array coded. Raises InvalidMessage."""
    if codec == "raw" or isinstance(token, Watermark):
        return pack(token)
    of_kind = codec_of(type(token))
    arrays = of_kind.arrays(token)
    head = bytearray(of_kind.head(token, arrays))
    head[1] = _CODES[codec]
    parts = [bytes(head)]
    for array in arrays:
        data = _coded(array, codec)
        block = _SIZE.size + len(data)
        parts += _SIZE.pack(len(data)), data, bytes(-block % ALIGN)
    return b"".join(parts)


def unpack_as(data: bytes, kind: type[Message]) -> Message | Watermark:
    """The token that `pack_as` packed with any codec. Raises InvalidMessage."""
    if len(data) < 2 or data[1] == RAW:
        return unpack(data, kind)
    if len(data) > MAX_PACKED:
        raise InvalidMessage(f"{len(data)} bytes, at most {MAX_PACKED} allowed")
    if data[1] not in (LOSSLESS, JPEG):
        raise InvalidMessage(f"arrays are coded in way {data[1]}, which is not known")
    head, place = unpack_head(data)
    if len(head) != 7:
        raise InvalidMessage(f"expected a head of 7 parts, not of {len(head)}")
    codec = codec_of(kind)
    shapes, spans = codec.shapes(head[6])
    total = sum(padded(span) for span in spans)
    if total > MAX_BYTES + len(spans) * ALIGN:
        raise InvalidMessage(f"{total} bytes of arrays, at most {MAX_BYTES} allowed")
    body = aligned(total)
    start = 0
    for shape, span in zip(shapes, spans, strict=True):
        if place + _SIZE.size > len(data):
            raise InvalidMessage("an array is missing")
        (size,) = _SIZE.unpack_from(data, place)
        if size > len(data) - place - _SIZE.size:
            raise InvalidMessage(f"an array of {size} bytes lies outside the {len(data)} that came")
        begin = place + _SIZE.size
        _decode(data[begin : begin + size], shape, body[start : start + span])
        place += padded(_SIZE.size + size)
        start += padded(span)
    if place != len(data):
        raise InvalidMessage(f"the arrays end at byte {place} of {len(data)}")
    return codec.decode(head, body)


def _coded(array: Array, codec: EdgeCodec) -> bytes:
    if array.dtype != np.uint8 or not _is_picture(array.shape):
        return zlib.compress(array.tobytes(), _FAST)
    import cv2

    if codec == "jpeg":
        _, data = cv2.imencode(".jpg", array, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    else:
        _, data = cv2.imencode(".png", array, [cv2.IMWRITE_PNG_COMPRESSION, _FAST])
    return data.tobytes()


def _decode(data: bytes, shape: Sequence[int], into: Array) -> None:
    """Decode one array into its place, (span,) uint8. Raises InvalidMessage."""
    if into.size == prod(shape) and _is_picture(shape) and not data.startswith(b"\x78"):
        into[:] = _picture(data, shape).reshape(-1)
        return
    inflate = zlib.decompressobj()
    try:
        found = inflate.decompress(data, len(into) + 1)
    except zlib.error as error:
        raise InvalidMessage(f"an array cannot be decompressed: {error}") from None
    if len(found) != len(into) or not inflate.eof:
        raise InvalidMessage(f"an array of shape {tuple(shape)} has another size when decompressed")
    into[:] = np.frombuffer(found, np.uint8)


def _picture(data: bytes, shape: Sequence[int]) -> Array:
    """Decode a PNG or JPEG; its size is checked first, for decoding allocates what the header claims."""
    height, width = _claimed(data)
    channels = shape[2] if len(shape) == 3 else 1
    if (height, width) != tuple(shape[:2]):
        raise InvalidMessage(f"a picture of {width} x {height} px came instead of {tuple(shape)}")
    import cv2

    try:
        image: Any = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise InvalidMessage(f"a picture cannot be decoded: {error}") from None
    if image is None or image.dtype != np.uint8 or image.size != height * width * channels:
        raise InvalidMessage(f"a picture cannot be decoded as {tuple(shape)}")
    return np.asarray(image)


def _claimed(data: bytes) -> tuple[int, int]:
    """Height and width, px, that a PNG or a JPEG claims to have. Raises InvalidMessage."""
    if data.startswith(_PNG) and len(data) >= 24:
        return int.from_bytes(data[20:24], "big"), int.from_bytes(data[16:20], "big")
    place = 2
    while data.startswith(b"\xff\xd8") and place + 9 <= len(data) and data[place] == 0xFF:
        marker = data[place + 1]
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):  # a frame header
            return int.from_bytes(data[place + 5 : place + 7], "big"), int.from_bytes(
                data[place + 7 : place + 9], "big"
            )
        place += 2 + int.from_bytes(data[place + 2 : place + 4], "big")
    raise InvalidMessage("a picture is neither PNG nor JPEG")


def _is_picture(shape: Sequence[int]) -> bool:
    """Whether an array of bytes may be coded as a picture: (H, W), or (H, W, 1 or 3)."""
    return (
        len(shape) in (2, 3)
        and (len(shape) == 2 or shape[2] in (1, 3))
        and 0 < min(shape[:2]) <= max(shape[:2]) <= 65000
    )
