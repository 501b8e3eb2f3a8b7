"""Packed pictures as FFV1 by PyAV, each a key frame; for comparison with what recordings do."""

from __future__ import annotations

from fractions import Fraction
from math import prod
from typing import Any

import av
import numpy as np

from followspot.transport.wire import ALIGN

_OPTIONS = {"level": "3", "coder": "1", "context": "0", "g": "1", "slicecrc": "0"}


class LosslessVideo:
    """shape: of the pictures, height, width, 3 uint8; size: bytes of a packed message."""

    def __init__(self, shape: tuple[int, ...], size: int) -> None:
        self._height, self._width, self._channels = shape
        self._padding = -prod(shape) % ALIGN
        self._head = size - prod(shape) - self._padding
        self._extra = b""

    def write(self, messages: list[bytes]) -> list[bytes]:
        """Heads and packets."""
        context: Any = av.CodecContext.create("ffv1", "w")
        context.width, context.height, context.pix_fmt = self._width, self._height, "bgr0"
        context.time_base, context.options, context.thread_count = Fraction(1, 30), _OPTIONS, 1
        packets = []
        for number, message in enumerate(messages):
            frame = av.VideoFrame(self._width, self._height, "bgr0")
            plane = np.frombuffer(frame.planes[0], "u1").reshape(self._height, -1)  # type: ignore[call-overload]
            pixels = np.frombuffer(message, "u1", offset=self._head)[: self._size].reshape(self._shape)
            rows = plane[:, : 4 * self._width].reshape(self._height, self._width, 4)
            rows[..., :3] = pixels
            frame.pts = number
            packets += [message[: self._head] + bytes(packet) for packet in context.encode(frame)]
        packets += [bytes(self._head) + bytes(packet) for packet in context.encode(None)]
        self._extra = bytes(context.extradata)
        return packets

    def read(self, blocks: list[bytes]) -> list[bytes]:
        """The packed messages."""
        context: Any = av.CodecContext.create("ffv1", "r")
        context.extradata, context.thread_count = self._extra, 1
        context.width, context.height, context.pix_fmt = self._width, self._height, "bgr0"
        return [
            block[: self._head] + self._pixels(frame)
            for block in blocks
            for frame in context.decode(av.Packet(block[self._head :]))
        ]

    @property
    def _shape(self) -> tuple[int, int, int]:
        return self._height, self._width, self._channels

    @property
    def _size(self) -> int:
        return self._height * self._width * self._channels

    def _pixels(self, frame: Any) -> bytes:
        plane = np.frombuffer(frame.planes[0], "u1").reshape(self._height, -1)
        rows = plane[:, : 4 * self._width].reshape(self._height, self._width, 4)
        return np.ascontiguousarray(rows[..., :3]).tobytes() + bytes(self._padding)
