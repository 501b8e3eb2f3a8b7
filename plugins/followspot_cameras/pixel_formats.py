"""Pictures of machine-vision cameras as 8-bit grey or BGR.

The names are those of the Pixel Format Naming Convention (PFNC 2.4): what is in a pixel (Mono, BayerRG, RGB),
bits, and p for packed from the least significant bit on; Packed is the older layout of GigE Vision 1.x.
Of 10, 12 and 16 bits the highest 8 are kept.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array

BAYER = {
    "BayerRG": cv2.COLOR_BayerRGGB2BGR,
    "BayerGR": cv2.COLOR_BayerGRBG2BGR,
    "BayerGB": cv2.COLOR_BayerGBRG2BGR,
    "BayerBG": cv2.COLOR_BayerBGGR2BGR,
}
_NAME = re.compile(r"(Mono|BayerRG|BayerGR|BayerGB|BayerBG)(8|10|12|16)(p|Packed)?")
_WHOLE = {"RGB8": (3, cv2.COLOR_RGB2BGR), "BGR8": (3, None)}
_WHOLE |= {"RGB8Packed": _WHOLE["RGB8"], "BGR8Packed": _WHOLE["BGR8"]}
_WHOLE |= dict.fromkeys(("YUV422_8_UYVY", "YUV422Packed", "YCbCr422_8_CbYCrY"), (2, cv2.COLOR_YUV2BGR_UYVY))
_WHOLE |= dict.fromkeys(("YUV422_8", "YCbCr422_8"), (2, cv2.COLOR_YUV2BGR_YUYV))
KNOWN = "Mono8, BayerRG8 (GR, GB, BG), both with 10, 12 and 16 bits, packed or not, RGB8, BGR8, YUV422_8"


class UnknownFormat(ValueError):
    """A pixel format that cannot be read; the text names it."""


class PixelFormat(NamedTuple):
    """channels: (H, W, channels) of the raw picture; to_bgr: OpenCV's conversion, None if it is none."""

    channels: int
    bits: int
    packing: str
    to_bgr: int | None


def pixel_format(name: str) -> PixelFormat:
    """The format of that name. Raises UnknownFormat."""
    if name in _WHOLE:
        channels, conversion = _WHOLE[name]
        return PixelFormat(channels, 8, "", conversion)
    found = _NAME.fullmatch(name)
    if found is None or (found[3] and found[2] not in ("10", "12")):
        raise UnknownFormat(f"pixel format {name} cannot be read; set PixelFormat to one of {KNOWN}")
    return PixelFormat(1, int(found[2]), found[3] or "", BAYER.get(found[1]))


def line_bytes(name: str, width: int) -> int:
    """Bytes of a line of pixels without padding. Raises UnknownFormat."""
    known = pixel_format(name)
    bits = {"Packed": 12, "p": known.bits, "": 16 if known.bits > 8 else 8}[known.packing]
    return -(-width * known.channels * bits // 8)


def converted(data: Array, size: tuple[int, int], name: str, out: Array, line: int = 0) -> Array:
    """The picture in `out`, (H, W, 3) BGR or (H, W, 1) grey, uint8.

    data: (B,) uint8, the payload; size: width and height, px; name: of the format; line: bytes from one line
    to the next, 0 if lines follow each other without padding. Raises UnknownFormat, ValueError if the payload
    is too short.
    """
    width, height = size
    used = line_bytes(name, width)
    if line > used and height:
        _require(data, line * (height - 1) + used)
        shape, strides = (height, used), (line, 1)
        data = np.lib.stride_tricks.as_strided(data, shape, strides, writeable=False).reshape(-1)
    if out.shape[2] == 3:
        return as_bgr(eight_bits(data, size, name), name, out)
    gray = pixel_format(name).channels == 1 and pixel_format(name).to_bgr is None
    if gray:
        eight_bits(data, size, name, out[..., 0])
        return out
    return as_gray(eight_bits(data, size, name), name, out)


def eight_bits(data: Array, size: tuple[int, int], name: str, out: Array | None = None) -> Array:
    """The raw picture with 8 bits a value, (H, W) or (H, W, C), uint8.

    data: (B,) uint8, the payload; size: width and height, px; name: of the format; out: where to put it, else
    8-bit payloads are not copied. Raises UnknownFormat, ValueError if the payload is too short.
    """
    width, height = size
    known = pixel_format(name)
    shape = (height, width) if known.channels == 1 else (height, width, known.channels)
    count = width * height * known.channels
    if known.bits == 8:
        _require(data, count)
        raw = data[:count].reshape(shape)
        if out is None:
            return raw
        np.copyto(out, raw)
        return out
    out = np.empty(shape, "u1") if out is None else out
    if known.packing:
        _unpack(data, count, known, out)
        return out
    _require(data, 2 * count)
    values = data[: 2 * count].view("<u2").reshape(shape)
    np.right_shift(values, known.bits - 8, out=out, casting="unsafe")
    return out


def as_bgr(raw: Array, name: str, out: Array | None = None) -> Array:
    """The picture in colour, (H, W, 3) BGR; out: where to put it. raw: of `eight_bits`."""
    conversion = pixel_format(name).to_bgr
    if conversion is None and raw.ndim == 2:
        conversion = cv2.COLOR_GRAY2BGR
    if conversion is not None:
        return np.asarray(cv2.cvtColor(raw, conversion, dst=out))
    if out is None:
        return raw.copy()
    np.copyto(out, raw)
    return out


def as_gray(raw: Array, name: str, out: Array) -> Array:
    """The picture in grey, (H, W, 1), in `out`. raw: of `eight_bits`."""
    if pixel_format(name).to_bgr is None and raw.ndim == 2:
        np.copyto(out[..., 0], raw)
    else:
        cv2.cvtColor(as_bgr(raw, name), cv2.COLOR_BGR2GRAY, dst=out)
    return out


def _require(data: Array, count: int) -> None:
    if len(data) < count:
        raise ValueError(f"the picture has {len(data)} of {count} bytes")


def _unpack(data: Array, count: int, known: PixelFormat, out: Array) -> None:
    """Put the highest 8 bits of packed values into `out`; values follow each other without padding."""
    members, size = (4, 5) if (known.bits, known.packing) == (10, "p") else (2, 3)
    groups = -(-count // members)
    _require(data, -(-count * size // members))
    padded = data[: groups * size]
    if len(padded) < groups * size:
        padded = np.concatenate([padded, np.zeros(groups * size - len(padded), "u1")])
    byte = padded.reshape(groups, size)
    whole = count == groups * members and out.flags.c_contiguous
    values = out.reshape(groups, members) if whole else np.empty((groups, members), "u1")
    if members == 4:  # Mono10p: 40 bits hold four values, the first in the lowest bits
        for n in range(4):
            low = 2 * (n + 1)
            values[:, n] = (byte[:, n] >> low if low < 8 else 0) | (byte[:, n + 1] << (8 - low))
    elif known.packing == "p":  # Mono12p
        values[:, 0] = byte[:, 0] >> 4 | byte[:, 1] << 4
        values[:, 1] = byte[:, 2]
    else:  # Mono10Packed, Mono12Packed: the lowest bits of both values stand in the middle byte
        values[:, 0], values[:, 1] = byte[:, 0], byte[:, 2]
    if not whole:
        out[...] = values.reshape(-1)[:count].reshape(out.shape)
