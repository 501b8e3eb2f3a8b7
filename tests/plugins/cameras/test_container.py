"""Whether a video file is all there."""

from io import BytesIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.plugins.cameras.recordings import record

from followspot_cameras.video.container import EBML, SEGMENT, cut_off, declared_size


@pytest.mark.parametrize(("name", "codec"), [("a.mkv", "MJPG"), ("a.avi", "MJPG"), ("a.mp4", "mp4v")])
def test_whole_file_declares_its_own_size_and_a_part_is_cut_off(
    tmp_path: Path, name: str, codec: str
) -> None:
    path = record(tmp_path / name, codec=codec)
    whole = path.read_bytes()
    with path.open("rb") as file:
        assert declared_size(file) == len(whole)
    assert cut_off(path) == ""
    path.write_bytes(whole[:-100])
    assert cut_off(path) == f" (the file is cut off: {len(whole) - 100} of {len(whole)} bytes)"


def test_stream_of_unknown_size_is_never_cut_off() -> None:
    assert declared_size(BytesIO(EBML + b"\x80" + SEGMENT + b"\x01" + b"\xff" * 7 + b"data")) == 0


@given(
    st.sampled_from([b"", EBML, b"RIFF", b"\0\0\0\x10ftyp", EBML + b"\x80" + SEGMENT]), st.binary(max_size=40)
)
def test_any_bytes_are_answered(head: bytes, rest: bytes) -> None:
    assert declared_size(BytesIO(head + rest)) >= 0
