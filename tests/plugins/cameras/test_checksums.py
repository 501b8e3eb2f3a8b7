"""The checksums of the clusters of a Matroska file."""

import math
import zlib
from io import BytesIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.plugins.cameras.recordings import record

from followspot_cameras.video.checksums import Checksums, clusters
from followspot_cameras.video.container import EBML, SEGMENT


def element(kind: str, content: bytes) -> bytes:
    """An element of EBML, with a size of four bytes."""
    return bytes.fromhex(kind) + (len(content) | 1 << 28).to_bytes(4, "big") + content


def cluster(time: int, data: bytes) -> bytes:
    """A cluster as FFmpeg writes it. time: of its pictures, in units of the file."""
    content = element("e7", time.to_bytes(3, "big")) + data
    return element("1f43b675", b"\xbf\x84" + zlib.crc32(content).to_bytes(4, "little") + content)


def matroska(*elements: bytes) -> bytes:
    """A whole file of these elements."""
    return EBML + b"\x80" + SEGMENT + element("18538067", b"".join(elements))[4:]


def damaged(path: Path, data: bytes) -> list[float]:
    path.write_bytes(data)
    with Checksums(path) as checksums:
        return list(checksums.damaged(math.inf))


PARTS = [element("ec", bytes(9)), *(cluster(1000 * n, bytes([n]) * 50) for n in range(3))]


@pytest.mark.parametrize(("name", "codec"), [("a.mkv", "MJPG"), ("a.mkv", "FFV1"), ("a.avi", "MJPG")])
def test_a_whole_file_matches(tmp_path: Path, name: str, codec: str) -> None:
    path = record(tmp_path / name, codec=codec)
    with path.open("rb") as file:
        assert bool(list(clusters(file))) == (name == "a.mkv")
    assert damaged(path, path.read_bytes()) == []


def test_each_damaged_cluster_is_told_once_and_when_it_is_due(tmp_path: Path) -> None:
    data = bytearray(matroska(*PARTS))
    data[data.index(b"\x01" * 50) + 7] = 3
    data[data.index(b"\x02" * 50) + 7] = 3
    (tmp_path / "a.mkv").write_bytes(data)
    with Checksums(tmp_path / "a.mkv") as checksums:
        found = [list(checksums.damaged(time)) for time in (0.0, 0.9, 1.0, 1.5, math.inf)]
    assert found == [[], [], [1.0], [], [2.0]]


def test_times_have_the_unit_of_the_file(tmp_path: Path) -> None:
    info = element("1549a966", b"\x2a\xd7\xb1\x83" + (100_000).to_bytes(3, "big"))
    data = matroska(info, cluster(5000, b"abc")).replace(b"abc", b"abd")
    assert damaged(tmp_path / "a.mkv", data) == [0.5]


def test_a_damaged_head_of_a_cluster_is_damage_from_the_one_before_on(tmp_path: Path) -> None:
    data = matroska(*PARTS)
    last = data.rindex(b"\x1f\x43\xb6\x75")
    assert damaged(tmp_path / "a.mkv", data[:last] + b"\x1e" + data[last + 1 :]) == [1.0]


@pytest.mark.parametrize("missing", [1, 30, 75])
def test_a_file_that_is_cut_off_is_not_damaged_before_that(tmp_path: Path, missing: int) -> None:
    assert damaged(tmp_path / "a.mkv", matroska(*PARTS)[:-missing]) == []


@given(st.binary(max_size=60))
def test_any_bytes_are_answered(rest: bytes) -> None:
    list(clusters(BytesIO(EBML + b"\x80" + SEGMENT + b"\x01" + b"\xff" * 7 + rest)))
    list(clusters(BytesIO(matroska(PARTS[1], rest))))
