"""Lenses of other programs: rational models, Tsai's, two matrices of one camera, and lenses without poses."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from tests.tools.exported import a_camera, back

from followspot import Camera, InputError
from followspot.geometry import project, project_local
from followspot.room import Room
from followspot.room_file import load, save
from followspot_room.calibration import read_calibration

AZURE = [0.54, -2.62, 0.0007, -0.0002, 1.53, 0.42, -2.43, 1.45]
"""Lens of a camera as its maker states it: no model with five coefficients comes closer than 2 px."""
LOCAL = np.random.default_rng(0).uniform([-0.5, -0.4, 1], [0.5, 0.4, 1], (50, 3))


def written(folder: Path, document: Any, name: str = "lenses.json") -> Path:
    (folder / name).write_text(json.dumps(document))
    return folder / name


def lens(**more: Any) -> dict[str, Any]:
    return {
        "K": [[606, 0, 640], [0, 607, 360], [0, 0, 1]],
        "dist": AZURE,
        "width": 1280,
        "height": 720,
        **more,
    }


def by_opencv(camera: Camera, lens: list[float]) -> np.ndarray:
    return cv2.projectPoints(LOCAL, np.zeros(3), np.zeros(3), camera.matrix, np.array(lens))[0][:, 0]


def test_rational_lens_is_read_exactly_and_kept_in_the_room_file(tmp_path: Path) -> None:
    (camera,) = read_calibration(written(tmp_path, {"a": lens()})).cameras
    assert camera.model == "rational"
    np.testing.assert_allclose(project_local(camera, LOCAL), by_opencv(camera, AZURE), atol=1e-9)
    save(Room("r", {"a": camera}), tmp_path / "room.yaml")
    again = load(tmp_path / "room.yaml").cameras["a"]
    assert (again.model, again.distortion.tolist()) == ("rational", AZURE)
    (read,) = back(tmp_path, "opencv", [camera])
    assert (read.model, read.distortion.tolist()) == ("rational", AZURE)
    with pytest.raises(InputError, match="camera a is a rational, which aniposelib cannot hold"):
        back(tmp_path, "anipose", [camera])


def test_eight_coefficients_without_a_denominator_are_a_pinhole(tmp_path: Path) -> None:
    (camera,) = read_calibration(written(tmp_path, {"a": lens(dist=[*AZURE[:5], 0, 0, 0])})).cameras
    assert (camera.model, camera.distortion.tolist()) == ("pinhole", AZURE[:5])
    with pytest.raises(InputError, match=r"dist needs k1, k2, p1, p2 and k3, or eight(.|\n)*thin-prism"):
        read_calibration(written(tmp_path, {"a": lens(dist=[*AZURE, 0, 0, 0, 0])}))


@pytest.mark.parametrize(
    "document",
    [
        {"cam": lens(dist=[[0.1, 0.2, 0, 0, 0]])},
        {"camera_matrix": lens()["K"], "dist_coeff": [[0.1], [0.2], [0], [0]], "image_size": [1280, 720]},
        {"cam": {"K": lens()["K"], "dist": [0.1, 0.2, 0, 0], "image_shape": [720, 1280]}},
        {"cameras": [lens(name="cam", dist=[0.1, 0.2, 0, 0])]},
    ],
)
def test_lenses_alone_are_read(tmp_path: Path, document: Any) -> None:
    calibration = read_calibration(written(tmp_path, document, "cam.json"))
    (camera,) = calibration.cameras
    assert (camera.name, camera.size) == ("cam", (1280, 720))
    assert camera.distortion.tolist() == [0.1, 0.2, 0, 0, 0]
    assert (camera.rotation == np.eye(3)).all()
    assert not camera.translation.any()


def test_two_lenses_without_poses_are_told(tmp_path: Path) -> None:
    calibration = read_calibration(written(tmp_path, {"a": lens(), "b": lens()}))
    assert not calibration.posed
    assert "no camera poses" in calibration.notes[0]
    posed = [lens(R=np.eye(3).tolist(), t=[x, 0, 0]) for x in (1, 2)]
    assert read_calibration(written(tmp_path, dict(zip("ab", posed, strict=True)))).posed


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"width": None}, r"camera a has no size of its pictures(.|\n)*width"),
        ({"R": np.eye(3).tolist()}, r"camera a has R but no t"),
        ({"K": [[1]]}, r"camera a: K has shape"),
    ],
)
def test_mistake_in_a_lens_is_told(tmp_path: Path, change: dict[str, Any], complaint: str) -> None:
    fields = {key: value for key, value in (lens() | change).items() if value is not None}
    with pytest.raises(InputError, match=complaint):
        read_calibration(written(tmp_path, {"a": fields}))


def two_matrices(folder: Path, **rad: float) -> None:
    """A result of MultiCamSelfCal whose .rad file has other entries of the matrix."""
    back(folder, "svoboda", [a_camera()])
    file = folder / "x/basename1.rad"
    lines = [line.partition(" = ")[::2] for line in file.read_text().splitlines()]
    file.write_text("".join(f"{key} = {rad.get(key, value)}\n" for key, value in lines))


def test_projection_is_p_and_distortion_about_the_lens_files_matrix(tmp_path: Path) -> None:
    two_matrices(tmp_path, K11=600.0, K22=590.0, K13=330.0)
    (read,) = (calibration := read_calibration(tmp_path / "x")).cameras
    true = a_camera()
    K = np.array([[600.0, 0, 330], [0, 590, 240], [0, 0, 1]])
    room = (LOCAL - true.translation) @ true.rotation
    straight = LOCAL @ true.matrix.T @ np.linalg.inv(K).T
    bent = replace(true, matrix=K)
    np.testing.assert_allclose(project(read, room), project_local(bent, straight), atol=0.5)
    np.testing.assert_allclose(read.center, true.center, atol=1e-9)
    assert "different matrices in camera1.Pmat.cal and its .rad file" in calibration.notes[0]
    assert "px off" in calibration.notes[0]


def test_matrices_that_no_lens_explains_are_refused(tmp_path: Path) -> None:
    two_matrices(tmp_path, K11=900.0, K22=300.0)
    with pytest.raises(InputError, match=r"camera left: its lens, with different matrices .* px off"):
        read_calibration(tmp_path / "x")


TSAI = """<?xml version="1.0" encoding="UTF-8"?>
<Camera name="View_001">
  <Geometry width="768" height="576" ncx="795" nfx="752" dx="0.0048" dy="0.0046" dpx="0.0051" dpy="0.0046"/>
  <Intrinsic focal="5.55" kappa1="0.0051" cx="324.22" cy="282.56" sx="1.0379"/>
  <Extrinsic tx="-4785.38" ty="2697.09" tz="36949.81" rx="1.7906" ry="-0.3031" rz="-0.0199"/>
</Camera>
"""


def tsai_pixel(point: np.ndarray) -> np.ndarray:
    """Image of a point of the room, m, by Tsai's equations as they stand in the paper."""
    rx, ry, rz = 1.7906, -0.3031, -0.0199
    R = (
        cv2.Rodrigues(np.array([0, 0, rz]))[0]
        @ cv2.Rodrigues(np.array([0, ry, 0]))[0]
        @ cv2.Rodrigues(np.array([rx, 0, 0]))[0]
    )
    x, y, z = R @ point * 1000 + [-4785.38, 2697.09, 36949.81]
    straight = 5.55 * np.array([x, y]) / z
    radius = np.linalg.norm(straight)
    bent = np.roots([0.0051, 0, 1, -radius])
    bent = bent[np.isreal(bent)].real.min()
    return straight * bent / radius / [0.0051 / 1.0379, 0.0046] + [324.22, 282.56]


def test_tsai_camera_sees_points_where_his_equations_do(tmp_path: Path) -> None:
    (tmp_path / "View_001.xml").write_text(TSAI)
    (camera,) = (calibration := read_calibration(tmp_path / "View_001.xml")).cameras
    assert (camera.name, camera.size) == ("View_001", (768, 576))
    pixel = np.array([[10.0, 20], [700, 50], [400, 300], [30, 550], [760, 570]])
    depths = np.array([10.0, 20, 30, 40, 15])
    K = camera.matrix
    local = np.column_stack([(pixel - K[:2, 2]) / K[[0, 1], [0, 1]], np.ones(5)]) * depths[:, None]
    points = (local - camera.translation) @ camera.rotation
    expected = np.array([tsai_pixel(point) for point in points])
    np.testing.assert_allclose(project(camera, points), expected, atol=0.3)
    assert "camera View_001: its lens by Tsai became a" in calibration.notes[0]


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('kappa1="0.0051" ', "", None),
        ('sx="1.0379"', "", "View_001.xml: <Intrinsic> lacks sx"),
        ('dpx="0.0051"', 'dpx="0"', "dpx, dpy, focal and sx must be positive"),
        ('focal="5.55"', 'focal="long"', "<Intrinsic> is not made of numbers"),
        ("</Camera>", "", "View_001.xml is no XML"),
        ("<Camera ", "<!DOCTYPE x><Camera ", "has a DOCTYPE"),
    ],
)
def test_mistake_in_tsais_file_is_told(tmp_path: Path, old: str, new: str, complaint: str | None) -> None:
    assert old in TSAI
    (tmp_path / "View_001.xml").write_text(TSAI.replace(old, new))
    with pytest.raises(InputError, match=complaint or "no calibration in a known format"):
        read_calibration(tmp_path / "View_001.xml")
