"""Frames made smaller for the way between hosts: lossless bit for bit, JPEG near enough, lies refused."""

from __future__ import annotations

import zlib

import cv2
import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.graph.plan import EdgeCodec
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, InvalidMessage, identical, stamped
from followspot.tracking import Blobs, Frame
from followspot.transport.codec import pack
from followspot.transport.token import Watermark
from followspot.transport.zenoh.codec import pack_as, unpack_as


def picture(height: int, width: int, channels: int, seed: int = 0) -> Array:
    """A smooth picture with some noise, as cameras make them."""
    rows, columns = np.mgrid[:height, :width]
    shade = (rows + 2 * columns) % 256 + np.random.default_rng(seed).integers(0, 4, (height, width))
    return np.repeat(np.clip(shade, 0, 255).astype("u1")[..., None], channels, axis=2)


def frame(pixels: Array) -> Frame:
    return stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", 3, 77, 5))


@given(height=st.integers(0, 40), width=st.integers(0, 40), channels=st.integers(1, 4))
def test_lossless_is_lossless_for_every_shape(height: int, width: int, channels: int) -> None:
    message = frame(picture(height, width, channels))
    found = unpack_as(pack_as(message, "lossless"), Frame)
    assert isinstance(found, Frame)
    assert identical(found, message)


def test_lossless_is_smaller_and_jpeg_smaller_still_and_near() -> None:
    message = frame(picture(240, 320, 3))
    sizes = [len(pack_as(message, codec)) for codec in ("raw", "lossless", "jpeg")]
    assert sizes[0] > 2 * sizes[1]
    assert sizes[1] > sizes[2]
    found = unpack_as(pack_as(message, "jpeg"), Frame)
    assert isinstance(found, Frame)
    error = found.pixels.astype(int) - message.pixels.astype(int)
    assert np.sqrt(np.mean(error**2)) < 4.0


@pytest.mark.parametrize("codec", ["raw", "lossless", "jpeg"])
def test_what_is_no_picture_is_never_changed(codec: EdgeCodec) -> None:
    message = stamped(seal(Blobs.empty()), Header("color/cam0", 1, 2, 3))
    found = unpack_as(pack_as(message, codec), Blobs)
    assert isinstance(found, Blobs)
    assert identical(found, message)
    assert unpack_as(pack_as(Watermark(9), codec), Blobs) == Watermark(9)


@pytest.mark.parametrize(("codec", "way"), [("lossless", 1), ("jpeg", 2)])
def test_a_stranger_decodes_coded_arrays_with_zlib_and_a_reader_of_pictures(
    codec: EdgeCodec, way: int
) -> None:
    """The recipe of docs/wire.md."""
    blobs = stamped(seal(Blobs.empty(camera="cam0")), Header("color/cam0", 1, 2, 3))
    for message in (frame(picture(24, 32, 3)), blobs):
        data = pack_as(message, codec)
        assert data[1] == way
        size = int.from_bytes(data[2:4], "little")
        *_, columns = msgpack.unpackb(data[4 : 4 + size])
        start = -(-(4 + size) // 64) * 64
        for name, dtype, shape in columns:
            length = int.from_bytes(data[start : start + 8], "little")
            code = data[start + 8 : start + 8 + length]
            start += -(-(8 + length) // 64) * 64
            if name == "pixels":
                found = cv2.imdecode(np.frombuffer(code, "u1"), cv2.IMREAD_UNCHANGED)
            else:
                found = np.frombuffer(zlib.decompress(code), dtype).reshape(shape)
            np.testing.assert_allclose(found, getattr(message, name), atol=12 if codec == "jpeg" else 0)
        assert start == len(data)


@pytest.mark.parametrize("codec", ["lossless", "jpeg"])
@given(place=st.integers(0, 10_000), value=st.integers(0, 255), cut=st.integers(0, 2000))
def test_damaged_bytes_are_a_message_or_refused(codec: EdgeCodec, place: int, value: int, cut: int) -> None:
    data = bytearray(pack_as(frame(picture(24, 32, 3)), codec))
    data[place % len(data)] = value
    try:
        found = unpack_as(bytes(data[: len(data) - cut]), Frame)
    except InvalidMessage:
        return
    assert isinstance(found, Frame)
    assert found.pixels.ndim == 3


def test_a_picture_that_claims_another_size_is_refused_before_it_is_decoded() -> None:
    data = bytearray(pack_as(frame(picture(24, 32, 3)), "lossless"))
    start = data.index(b"\x89PNG")
    data[start + 16 : start + 20] = (60_000).to_bytes(4, "big")
    with pytest.raises(InvalidMessage, match="60000 x 24 px came"):
        unpack_as(bytes(data), Frame)


def test_a_way_of_coding_that_is_not_known_is_refused() -> None:
    data = bytearray(pack(frame(picture(4, 4, 1))))
    data[1] = 9
    with pytest.raises(InvalidMessage, match="coded in way 9"):
        unpack_as(bytes(data), Frame)
