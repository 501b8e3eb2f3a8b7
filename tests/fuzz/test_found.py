"""What fuzzing has found: each input once, so that it stays mended."""

from __future__ import annotations

import io
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from followspot.context import Context
from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.room import Camera
from followspot_calibrate.points_file.reading import read_points
from followspot_cameras.images import Images
from followspot_sim.parameters import SimParams
from followspot_sinks.datagrams import Datagrams


def keypoints(**more: Any) -> bytes:
    kept = io.BytesIO()
    np.savez_compressed(kept, keypoints=np.ones((2, 3, 1, 3)), **more)
    return kept.getvalue()


def with_compression(data: bytes, method: int) -> bytes:
    """The archive, its members said to be compressed in this way."""
    found = bytearray(data)
    for signature, offset in ((b"PK\3\4", 8), (b"PK\1\2", 10)):
        place = found.index(signature) + offset
        found[place : place + 2] = method.to_bytes(2, "little")
    return bytes(found)


def claiming_shape(shape: str) -> bytes:
    """An archive with an array whose head claims more than is there."""
    head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    kept = io.BytesIO()
    with zipfile.ZipFile(kept, "w") as archive:
        archive.writestr("keypoints.npy", b"\x93NUMPY\1\0" + len(head).to_bytes(2, "little") + head.encode())
    return kept.getvalue()


@pytest.mark.parametrize(
    "data",
    [
        with_compression(keypoints(), 97),
        keypoints()[:100] + bytes(8) + keypoints()[108:],
        claiming_shape("(100000000, 100000000, 2, 3)"),
    ],
    ids=["unknown compression", "damaged stream", "claims a huge array"],
)
def test_an_archive_of_keypoints_that_is_damaged_is_refused(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "points.npz"
    path.write_bytes(data)
    with pytest.raises(InputError, match="cannot be read"):
        read_points(path, size=(320, 240))


@pytest.mark.parametrize("views", [np.full((2, 4), "wide"), np.full((2, 4), np.nan), np.full((2, 4), 1e300)])
def test_sizes_of_pictures_that_are_none_are_not_believed(tmp_path: Path, views: np.ndarray) -> None:
    path = tmp_path / "points.npz"
    path.write_bytes(keypoints(views_xywh=views))
    found = read_points(path, size=(320, 240))
    assert found.sizes.tolist() == [[320, 240]] * 2


@pytest.mark.parametrize(
    "size", ["8 2000000000", "2000000000 8", "1000000 1000000", "99999999999 1", "30000 30000"]
)
def test_a_picture_that_claims_a_size_beyond_reason_leaves_a_gap(tmp_path: Path, size: str) -> None:
    (tmp_path / "frame0.ppm").write_bytes(b"P6 " + size.encode() + b" 255 " + bytes(100))
    (tmp_path / "frame1.ppm").write_bytes(b"P6 8 6 255 " + bytes(8 * 6 * 3))
    eye = np.eye(3)
    camera = Camera("cam0", "color", (8, 6), eye, np.zeros(5), eye, np.zeros(3))
    warnings: list[str] = []
    stage = Images(Context.serving(camera, name="camera/cam0", warn=warnings.append), path=tmp_path)
    stage.setup()
    assert [frame.header.seq for frame in stage.process()] == [1]
    assert "frame0.ppm" in warnings[0]


def refused(folder: Path, stage: str, params: str) -> list[str]:
    """The mistakes of a graph with this stage and these parameters."""
    (folder / "g.yaml").write_text(f"graph: g\nstages:\n  a: {{uses: {stage}, with: {params}}}\n")
    try:
        compile_graph(folder / "g.yaml")
    except InputError as error:
        return [mistake.text for mistake in error.mistakes]
    return []


@pytest.mark.parametrize(
    ("stage", "params", "said"),
    [
        ("balls.bridge", "{gate: 1e300}", "0 or from 1e-15 to 1e+15"),
        ("balls.kalman", "{acceleration_sigma: 1e-300}", "0 or from 1e-15 to 1e+15"),
        ("balls.kalman", "{acceleration_sigma: .inf}", "finite number"),
        ("sim.truth", "{frames: '9223372036854775808'}", "64 bits"),
        ("sim.truth", "{fps: 1e-9}", "greater than or equal to 0.001"),
        ("sim.pose_truth", "{walking_area: [2, -1.6, 1.8, 1.6]}", "x0 < x1"),
        ("persons.fusion", "{distance_sigma: 1e9}", "less than or equal to 100"),
        ("sinks.udp_json", '{host: "a\\0b"}', "must not contain a NUL"),
        ("sinks.csv", "{path: " + "x" * 300 + "}", "more than 255 bytes"),
    ],
)
def test_a_parameter_that_no_stage_could_work_with_is_a_mistake(
    tmp_path: Path, stage: str, params: str, said: str
) -> None:
    assert any(said in text for text in refused(tmp_path, stage, params))


def test_a_negative_zero_is_zero() -> None:
    assert math.copysign(1.0, SimParams(noise_sigma=-0.0).noise_sigma) == 1.0


@pytest.mark.parametrize("pattern", [".", "..", "**", "**x", "["])
def test_a_pattern_that_no_picture_matches_is_told(tmp_path: Path, pattern: str) -> None:
    (tmp_path / "frame0.png").write_bytes(b"")
    eye = np.eye(3)
    camera = Camera("cam0", "color", (8, 6), eye, np.zeros(5), eye, np.zeros(3))
    stage = Images(Context.serving(camera, name="camera/cam0"), path=tmp_path, pattern=pattern)
    if pattern == "**":
        stage.setup()  # as "*"
    else:
        with pytest.raises(InputError, match="has no pictures"):
            stage.setup()


def test_a_host_that_cannot_be_a_name_is_told() -> None:
    for host in ("x" * 300, "a..b", "."):
        with pytest.raises(InputError, match="cannot send to"):
            Datagrams(host, 9, "127.0.0.1", print)
