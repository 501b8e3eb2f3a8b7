"""Calibrations in OpenCV-style JSON, and what is in no known format."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from followspot import InputError
from followspot_room.calibration import read_calibration

GLOWBALLS = dataset("glowballs-dev")
needs_recordings = needs_data("glowballs-dev")


def camera(**changes: Any) -> dict[str, Any]:
    fields = {
        "name": "left",
        "kind": "ir",
        "width": 320,
        "height": 240,
        "K": [[200, 0, 160], [0, 201, 120], [0, 0, 1]],
        "dist": [-0.2, 0.1, 0, 0, 0.01],
        "R": np.eye(3).tolist(),
        "t": [0.1, 0.2, 3],
    }
    return {k: v for k, v in (fields | changes).items() if v is not None}


def written(folder: Path, document: Any) -> Path:
    path = folder / "calibration.json"
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


def test_cameras_planes_and_radius_are_read(tmp_path: Path) -> None:
    planes = {"floor": {"metres": [0, 0, 2, 4]}, "wall": [1, 0, 0, -2.5]}
    document = {"cameras": [camera()], "planes": planes, "ball_radius_m": 0.05}
    got = read_calibration(written(tmp_path, document))
    (left,) = got.cameras
    assert (left.name, left.kind, left.size, left.model) == ("left", "infrared", (320, 240), "pinhole")
    np.testing.assert_array_equal(left.distortion, [-0.2, 0.1, 0, 0, 0.01])
    np.testing.assert_array_equal(left.translation, [0.1, 0.2, 3])
    np.testing.assert_array_equal(got.planes["floor"], [0, 0, 1, 2])
    np.testing.assert_array_equal(got.planes["wall"], [1, 0, 0, -2.5])
    assert got.ball_radius == 0.05


@pytest.mark.parametrize(("number", "called"), [(3, "3"), ("left", "left")])
def test_cameras_may_be_numbered(tmp_path: Path, number: object, called: str) -> None:
    one = camera() | {"camera": number}
    del one["name"]
    (found,) = read_calibration(written(tmp_path, {"cameras": [one]})).cameras
    assert found.name == called


def test_short_distortion_is_filled_with_zeros(tmp_path: Path) -> None:
    document = {"cameras": [camera(name="a", dist=None), camera(name="b", dist=[1, 2, 3, 4])]}
    a, b = read_calibration(written(tmp_path, document)).cameras
    assert a.distortion.tolist() == [0] * 5
    assert b.distortion.tolist() == [1, 2, 3, 4, 0]


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"R": (2 * np.eye(3)).tolist()}, "camera left: R is no rotation"),
        ({"R": np.diag([1, 1, -1]).tolist()}, "camera left: R is no rotation"),
        ({"K": [[200, 0, 160], [0, 200, 120]]}, r"K has shape \(2, 3\), needs \(3, 3\)"),
        ({"K": [[-1, 0, 160], [0, 200, 120], [0, 0, 1]]}, "K is no camera matrix"),
        ({"K": "K"}, "K is not made of numbers"),
        ({"t": [0, 0, float("nan")]}, "t has a number that is not finite"),
        ({"dist": [0] * 7}, "dist needs k1, k2, p1, p2 and k3"),
        ({"width": "wide"}, "width is 'wide', needs a number of pixels"),
        ({"kind": "thermal"}, "kind 'thermal', known: color"),
        ({"name": "../../etc/passwd"}, "has the name '../../etc/passwd'"),
        ({"name": None}, "has the name None"),
    ],
)
def test_mistake_names_camera_and_field(tmp_path: Path, changes: dict[str, Any], complaint: str) -> None:
    fields = camera(**changes)
    with pytest.raises(InputError, match=complaint):
        read_calibration(written(tmp_path, {"cameras": [fields]}))


def test_camera_that_is_there_twice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="camera left is there twice"):
        read_calibration(written(tmp_path, {"cameras": [camera(), camera()]}))


@pytest.mark.parametrize("planes", [{"floor": [0, 0, 0, 1]}, {"floor": {"feet": [0, 0, 1, 0]}}, [1, 2]])
def test_plane_that_is_none_is_refused(tmp_path: Path, planes: Any) -> None:
    with pytest.raises(InputError, match="planes"):
        read_calibration(written(tmp_path, {"cameras": [camera()], "planes": planes}))


@pytest.mark.parametrize(
    "text", ["", "not json", "[]", '{"cameras": []}', '{"cameras": [{"fx": 1}]}', "[" * 10**5]
)
def test_unknown_format_is_answered_with_the_known_ones(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match="is no calibration in a known format") as caught:
        read_calibration(written(tmp_path, text))
    assert "K, dist, and R and t" in str(caught.value)


@needs_recordings
@pytest.mark.parametrize("name", ["calibration.json", "calibration_noisy.json"])
def test_shared_calibrations_are_read(name: str) -> None:
    got = read_calibration(GLOWBALLS / name)
    kinds = {c.name: c.kind for c in got.cameras}
    assert [n for n, kind in kinds.items() if kind == "color"] == ["cam0", "cam2", "cam5"]
    assert sorted(got.planes) == ["ground", "vertical"]
    assert got.ball_radius == 0.0762
