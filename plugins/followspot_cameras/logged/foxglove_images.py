"""Pictures in Foxglove's schemas, foxglove.RawImage and foxglove.CompressedImage."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np

from followspot.frame_times import SECOND
from followspot_cameras.logged.protobuf import fields
from followspot_cameras.logged.stored_image import StoredImage

RAW, COMPRESSED = "foxglove.RawImage", "foxglove.CompressedImage"
SCHEMAS = (RAW, COMPRESSED)
ENCODINGS = ("protobuf", "json")


def stored_image(schema: str, encoding: str, data: bytes, logged: int) -> StoredImage:
    """The picture of a message. schema, encoding: of `SCHEMAS` and `ENCODINGS`.

    Its capture time is the message's timestamp, or `logged`, ns, if that is 0. Raises ValueError.
    """
    return (_of_json if encoding == "json" else _of_protobuf)(schema, data, logged)


def _of_json(schema: str, data: bytes, logged: int) -> StoredImage:
    try:
        said: Any = json.loads(data)
        stamp = said["timestamp"]
        pixels = np.frombuffer(base64.b64decode(said["data"], validate=True), "u1")
        time = _time(int(stamp["sec"]), int(stamp["nsec"]), logged)
        if schema == COMPRESSED:
            return StoredImage(time, pixels)
        width, height, step = (int(said[name]) for name in ("width", "height", "step"))
        return StoredImage(time, pixels, str(said["encoding"]), width, height, step)
    except (KeyError, TypeError, RecursionError, OverflowError) as error:
        raise ValueError(f"no {schema}: {type(error).__name__} {error}") from None


def _of_protobuf(schema: str, data: bytes, logged: int) -> StoredImage:
    said = fields(data)
    stamp = fields(_bytes(said.get(1, b"")))
    time = _time(_number(stamp.get(1, 0)), _number(stamp.get(2, 0)), logged)
    if schema == COMPRESSED:
        return StoredImage(time, np.frombuffer(_bytes(said.get(2, b"")), "u1"))
    width, height, step = (_number(said.get(number, 0)) for number in (2, 3, 5))
    encoding = _bytes(said.get(4, b"")).decode()
    return StoredImage(time, np.frombuffer(_bytes(said.get(6, b"")), "u1"), encoding, width, height, step)


def _time(seconds: int, nanoseconds: int, logged: int) -> int:
    return seconds * SECOND + nanoseconds or logged


def _bytes(value: int | bytes) -> bytes:
    if isinstance(value, int):
        raise ValueError("a number where bytes belong")
    return value


def _number(value: int | bytes) -> int:
    if isinstance(value, bytes):
        raise ValueError("bytes where a number belongs")
    return value
