"""Raw pictures of machine-vision cameras: bits, packing, colour filters, short payloads."""

from __future__ import annotations

import numpy as np
import pytest

from followspot_cameras.pixel_formats import (
    UnknownFormat,
    as_bgr,
    as_gray,
    converted,
    eight_bits,
    line_bytes,
    pixel_format,
)

SIZE = (6, 4)
rng = np.random.default_rng(5)


def packed(values: np.ndarray, bits: int, layout: str) -> np.ndarray:
    """The layouts bit by bit: "p" from the least significant bit on, and GigE Vision's "Packed"."""
    if layout == "p":
        stream = (values[:, None] >> np.arange(bits) & 1).astype("u1").ravel()
        return np.packbits(stream, bitorder="little")
    high, low = values >> (bits - 8), values & ((1 << (bits - 8)) - 1)
    first, second = slice(0, None, 2), slice(1, None, 2)
    return np.stack([high[first], low[first] | low[second] << 4, high[second]], axis=1).astype("u1").ravel()


@pytest.mark.parametrize("bits", [10, 12])
@pytest.mark.parametrize("layout", ["p", "Packed"])
def test_packed_values_keep_their_highest_eight_bits(bits: int, layout: str) -> None:
    values = rng.integers(0, 1 << bits, SIZE[0] * SIZE[1])
    raw = eight_bits(packed(values, bits, layout), SIZE, f"Mono{bits}{layout}")
    assert (raw == (values >> (bits - 8)).reshape(4, 6)).all()


def test_packed_values_that_fill_no_whole_group_are_read() -> None:
    values = rng.integers(0, 1024, 21)
    assert (eight_bits(packed(values, 10, "p"), (7, 3), "Mono10p").ravel() == values >> 2).all()


@pytest.mark.parametrize("bits", [10, 12, 16])
def test_unpacked_values_keep_their_highest_eight_bits(bits: int) -> None:
    values = rng.integers(0, 1 << bits, 24).astype("<u2")
    assert (eight_bits(values.view("u1"), SIZE, f"Mono{bits}").ravel() == values >> (bits - 8)).all()


@pytest.mark.parametrize(("tile", "red"), [("RG", (0, 0)), ("GR", (0, 1)), ("GB", (1, 0)), ("BG", (1, 1))])
def test_bayer_pictures_have_red_where_the_filter_has_it(tile: str, red: tuple[int, int]) -> None:
    mosaic = np.zeros((16, 16), "u1")
    mosaic[red[0] :: 2, red[1] :: 2] = 200
    bgr = as_bgr(eight_bits(mosaic.ravel(), (16, 16), f"Bayer{tile}8"), f"Bayer{tile}8")
    assert (bgr[4:12, 4:12] == (0, 0, 200)).all()


def test_a_colour_becomes_the_same_from_every_colour_format() -> None:
    rgb = np.full((4, 6, 3), (200, 100, 50), "u1")
    assert (as_bgr(eight_bits(rgb.ravel(), SIZE, "RGB8"), "RGB8") == (50, 100, 200)).all()
    assert (as_bgr(eight_bits(rgb.ravel(), SIZE, "BGR8"), "BGR8") == (200, 100, 50)).all()


def test_a_picture_lands_in_the_array_that_is_lent() -> None:
    lent = np.empty((4, 6, 3), "u1")
    gray = rng.integers(0, 255, 24).astype("u1")
    assert as_bgr(eight_bits(gray, SIZE, "Mono8"), "Mono8", lent) is lent
    assert (lent == gray.reshape(4, 6, 1)).all()
    mono = np.empty((4, 6, 1), "u1")
    assert as_gray(eight_bits(gray, SIZE, "Mono8"), "Mono8", mono) is mono
    assert (mono.ravel() == gray).all()


@pytest.mark.parametrize("name", ["Mono8", "Mono12p", "Mono16", "RGB8", "BayerRG10Packed", "YUV422_8"])
def test_a_payload_that_is_too_short_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="the picture has 10 of"):
        eight_bits(np.zeros(10, "u1"), SIZE, name)


@pytest.mark.parametrize("name", ["Coord3D_ABC32f", "Mono8p", "Mono16Packed", "Mono9", ""])
def test_a_format_that_cannot_be_read_is_named(name: str) -> None:
    with pytest.raises(UnknownFormat, match="set PixelFormat to one of Mono8"):
        pixel_format(name)


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize(
    "name", ["Mono8", "Mono12p", "Mono10Packed", "Mono16", "BayerRG8", "RGB8", "YUV422_8"]
)
def test_bytes_that_fill_up_lines_are_no_pixels(name: str, channels: int) -> None:
    used = line_bytes(name, SIZE[0])
    lines = rng.integers(0, 255, (SIZE[1], used)).astype("u1")
    padded = np.hstack([lines, np.full((SIZE[1], 5), 255, "u1")]).ravel()
    shape = (SIZE[1], SIZE[0], channels)
    plain = converted(lines.ravel(), SIZE, name, np.empty(shape, "u1"))
    for data in (padded, padded[:-5]):  # the last line may end with its pixels
        assert (converted(data, SIZE, name, np.empty(shape, "u1"), used + 5) == plain).all()
    with pytest.raises(ValueError, match="the picture has"):
        converted(padded[:-6], SIZE, name, np.empty(shape, "u1"), used + 5)


@pytest.mark.parametrize("name", ["Mono8", "Mono10", "Mono10p", "Mono12Packed", "Mono16"])
def test_a_grey_picture_is_written_into_the_slot_at_once(name: str) -> None:
    data = rng.integers(0, 255, line_bytes(name, SIZE[0]) * SIZE[1]).astype("u1")
    slot = np.empty((SIZE[1], SIZE[0], 1), "u1")
    assert converted(data, SIZE, name, slot) is slot
    assert (slot[..., 0] == eight_bits(data, SIZE, name)).all()
