"""A folder of 16-bit PNG files as a depth camera."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.plugins.cameras.recordings import SIZE, context

from followspot import InputError
from followspot.message_checks.sealing import seal
from followspot.testing import check_stage, tiny_room
from followspot_cameras.depth_images import DepthImages, written

SHAPE = (SIZE[1], SIZE[0])


def levels(number: int) -> np.ndarray:
    return (np.arange(SIZE[0] * SIZE[1]).reshape(SHAPE) * 7 + number).astype(np.uint16)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for number in range(12):
        cv2.imwrite(str(tmp_path / f"depth{number}.png"), levels(number))
    (tmp_path / "preview0.jpg").write_text("not a depth image")
    return tmp_path


def play(folder: Path, warnings: list[str] | None = None, **params: object) -> list:
    log: list[str] = [] if warnings is None else warnings
    images = DepthImages(context("depth", warn=log.append), path=folder, **params)
    images.setup()
    return [seal(message) for message in images.process()]


def test_levels_become_metres_and_zero_stays_unmeasured(folder: Path) -> None:
    shots = play(folder, fps=10)
    assert [shot.header[1:3] for shot in shots] == [(n, n * 100_000_000) for n in range(12)]
    assert shots[0].depth.dtype == np.float32
    assert shots[0].depth[0, 0] == 0
    assert np.allclose(shots[3].depth, levels(3) / 1000, rtol=1e-6)
    (coarse,) = play(folder, unit=0.0002, start_frame=5, frames=1)
    assert coarse.header.seq == 5
    assert np.allclose(coarse.depth, levels(5) / 5000, rtol=1e-6)


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    depth = np.full(SHAPE, 1.234, np.float32)
    depth[0, :4] = np.nan, np.inf, -1.0, 70.0
    written(tmp_path / "a.png", depth)
    (again,) = play(tmp_path)
    assert np.array_equal(again.depth[0, :4], np.zeros(4))
    assert np.allclose(again.depth[1:], 1.234)


def claiming(width: int, height: int, bits: int = 16, color: int = 0) -> bytes:
    """A PNG file that claims a form and has hardly any data."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, bits, color, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(b"\0"))
        + chunk(b"IEND", b"")
    )


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (claiming(2_000_000_000, 2_000_000_000), "pictures of 2000000000x2000000000 px"),
        (claiming(*SIZE, bits=8), "8-bit grey pictures, but depth images are 16-bit grey PNG files"),
        (claiming(*SIZE, color=2), "16-bit colour pictures"),
        (claiming(*SIZE, color=6), "16-bit colour pictures"),
        (claiming(*SIZE, bits=8, color=3), "8-bit colour pictures"),
        (claiming(32, 48), "calibrated for 64x48 px"),
    ],
)
def test_a_picture_of_another_form_is_one_clear_error(tmp_path: Path, data: bytes, text: str) -> None:
    (tmp_path / "depth0.png").write_bytes(data)
    with pytest.raises(InputError) as raised:
        play(tmp_path)
    (mistake,) = raised.value.mistakes
    assert "depth0.png has" in mistake.text
    assert text in mistake.text
    assert mistake.remedy


@pytest.mark.parametrize("cut", [0, 5, 30, 200, 900])
def test_a_damaged_file_leaves_a_gap_and_is_reported(folder: Path, cut: int) -> None:
    damaged = folder / "depth4.png"
    damaged.write_bytes(damaged.read_bytes()[:cut])
    warnings: list[str] = []
    assert [shot.header.seq for shot in play(folder, warnings)] == [0, 1, 2, 3, *range(5, 12)]
    assert warnings == ["1 pictures cannot be read, the first is depth4.png"]


def test_folder_without_depth_images_is_refused(tmp_path: Path) -> None:
    (tmp_path / "preview0.jpg").write_text("not a depth image")
    with pytest.raises(InputError, match=r"pictures end in .png"):
        play(tmp_path)


def test_it_keeps_the_promises_of_stages(folder: Path) -> None:
    check_stage(DepthImages, room=tiny_room("depth", "depth"), path=folder)
