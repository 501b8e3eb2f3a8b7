"""A picture as a log file holds it: raw pixels in a named encoding, or a compressed file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from followspot.errors import InputError
from followspot.messages import Array

COMPRESSED = ""
_AS_IT_IS = -1

ENCODINGS: dict[str, tuple[int, int, int]] = {
    "mono8": (1, 1, _AS_IT_IS),
    "8UC1": (1, 1, _AS_IT_IS),
    "mono16": (1, 2, _AS_IT_IS),
    "bgr8": (3, 1, _AS_IT_IS),
    "8UC3": (3, 1, _AS_IT_IS),
    "rgb8": (3, 1, cv2.COLOR_RGB2BGR),
    "bgra8": (4, 1, cv2.COLOR_BGRA2BGR),
    "8UC4": (4, 1, cv2.COLOR_BGRA2BGR),
    "rgba8": (4, 1, cv2.COLOR_RGBA2BGR),
    "bayer_rggb8": (1, 1, cv2.COLOR_BayerRGGB2BGR),
    "bayer_bggr8": (1, 1, cv2.COLOR_BayerBGGR2BGR),
    "bayer_gbrg8": (1, 1, cv2.COLOR_BayerGBRG2BGR),
    "bayer_grbg8": (1, 1, cv2.COLOR_BayerGRBG2BGR),
    "yuv422": (2, 1, cv2.COLOR_YUV2BGR_UYVY),
    "uyvy": (2, 1, cv2.COLOR_YUV2BGR_UYVY),
    "yuv422_yuy2": (2, 1, cv2.COLOR_YUV2BGR_YUY2),
    "yuyv": (2, 1, cv2.COLOR_YUV2BGR_YUY2),
}
"""Name of ROS and Foxglove -> channels, bytes of each, conversion of OpenCV."""


@dataclass(frozen=True)
class StoredImage:
    """A picture and its capture time, ns. encoding: of `ENCODINGS`, or `COMPRESSED`; step: bytes of a row."""

    time: int
    data: Array
    encoding: str = COMPRESSED
    width: int = 0
    height: int = 0
    step: int = 0
    big_endian: bool = False

    def decoded(self, check_size: Callable[[int, int], None]) -> Array | None:
        """(H, W, 3) BGR or (H, W) grey, uint8; None if it cannot be decoded.

        Of 16 bits the highest eight are kept. check_size: called with the width and height that raw pixels
        claim, before they are converted. Raises InputError for an encoding that is unknown.
        """
        if self.encoding == COMPRESSED:
            return _decompressed(self.data)
        if self.encoding not in ENCODINGS:
            text = f'pictures have the encoding "{self.encoding[:40]}"'
            raise InputError.of(text, f"known encodings: {', '.join(ENCODINGS)}, and compressed pictures")
        channels, size, conversion = ENCODINGS[self.encoding]
        check_size(self.width, self.height)
        used = self.width * channels * size
        if self.step < used or len(self.data) < self.step * (self.height - 1) + used:
            return None
        rows = np.lib.stride_tricks.as_strided(
            self.data, (self.height, used), (self.step, 1), writeable=False
        )
        if size == 2:
            return np.ascontiguousarray(rows[:, 0 if self.big_endian else 1 :: 2])
        pixels = np.ascontiguousarray(rows).reshape(self.height, self.width, channels)
        try:
            return pixels if conversion == _AS_IT_IS else np.asarray(cv2.cvtColor(pixels, conversion))
        except cv2.error:  # an odd width has no pairs of YUV
            return None


def _decompressed(data: Array) -> Array | None:
    """The picture of a JPEG, PNG or other file; None if it is none."""
    try:
        return cv2.imdecode(data, cv2.IMREAD_COLOR) if len(data) else None
    except cv2.error:
        return None
