"""Pictures as differences of their rows: every bit comes back, and noise takes fewer bytes."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st

from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, InvalidMessage, Message, column, stamped
from followspot.tracking import Frame, Tracks
from followspot.transport.codec import pack
from followspot.transport.row_differences import ROWS, differenced, restored
from followspot.transport.wire import pack_head


class Depth(Message):
    """Three arrays, of which the middle one is a picture of 16 bits."""

    first: Array = column("N", dtype="<f8", unit="m")
    depth: Array = column("H", "W", dtype="<u2", unit="mm")
    last: Array = column("N", dtype="<i4", unit="1")


def frame(pixels: Array) -> bytes:
    return pack(stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", 7, 9)))


@given(st.integers(1, 40), st.integers(1, 40), st.sampled_from([1, 3]), st.integers(0, 99))
def test_every_bit_comes_back(height: int, width: int, channels: int, seed: int) -> None:
    data = frame(np.random.default_rng(seed).integers(0, 256, (height, width, channels), "u1"))
    coded = differenced(data)
    assert len(coded) == len(data)
    assert restored(coded) == data


def test_every_bit_comes_back_of_wide_pictures() -> None:
    data = frame(np.random.default_rng(2).integers(0, 256, (9, 700, 3), "u1"))
    assert restored(differenced(data)) == data


def test_pictures_of_16_bits_stand_between_other_arrays() -> None:
    rng = np.random.default_rng(1)
    depth = rng.integers(0, 1 << 16, (30, 50), "u2")
    data = pack(stamped(seal(Depth(rng.random(5), depth, np.arange(5, dtype="i4"))), Header("d", 0, 0)))
    coded = differenced(data)
    assert coded[1] == ROWS
    assert coded != data
    assert restored(memoryview(coded)) == data


def test_the_first_row_stays_and_the_others_are_differences() -> None:
    pixels = np.cumsum(np.ones((40, 40, 1), "u1"), axis=0, dtype="u1") * 9
    coded = differenced(frame(pixels))
    assert coded.endswith(bytes([9]) * 1600)


def test_what_has_no_picture_is_left_alone() -> None:
    data = pack(stamped(seal(Tracks.empty()), Header("track", 0, 0)))
    assert differenced(data) is data
    assert restored(data) is data


def test_a_noisy_picture_takes_two_thirds_of_the_bytes() -> None:
    """Noise of 3 in gray levels has 3.6 bits a byte, the difference of two such rows 4.1 of 8."""
    slope = np.linspace(20, 120, 320)[None, :, None] + np.zeros((240, 320, 3))
    data = frame(np.clip(np.random.default_rng(0).normal(slope, 3.0), 0, 255).astype("u1"))
    plain, coded = (len(zstandard.compress(text, 1)) for text in (data, differenced(data)))
    assert coded < 0.7 * plain
    assert coded < 0.56 * len(data)


@pytest.mark.parametrize(
    "columns",
    [
        [["pixels", "|u1", [1 << 40, 1 << 40, 3]]],
        [["pixels", "|u1", [-1, 4, 3]]],
        [["pixels", "O", [4, 4]]],
        [["pixels", "V99", [4, 4]]],
        [["pixels", 3, [4, 4]]],
        [["pixels", "|u1", [True, 4]]],
        [["pixels", "|u1"]],
        ["pixels"],
    ],
)
def test_columns_that_are_none_are_refused(columns: object) -> None:
    data = bytearray(pack_head(("Frame", "camera", 0, 0, 0, {}, columns)) + bytes(4096))
    data[1] = ROWS
    with pytest.raises(InvalidMessage):
        restored(bytes(data))


@given(st.binary(max_size=200), st.integers(0, 400), st.integers(0, 255))
def test_hostile_bytes_never_grow(junk: bytes, where: int, value: int) -> None:
    data = bytearray(differenced(frame(np.zeros((20, 20, 3), "u1"))))
    data[where : where + len(junk)] = junk
    data[0:2] = bytes([1, ROWS])
    data[min(where, len(data) - 1)] = value
    with suppress(InvalidMessage):
        assert len(restored(bytes(data))) == len(data)
