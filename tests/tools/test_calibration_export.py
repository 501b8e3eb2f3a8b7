"""Cameras of a room, written for other programs and read back."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.tools.exported import a_camera, back
from tests.tools.qualisys_file import qualisys

from followspot.cli.main import main
from followspot.errors import InputError
from followspot.geometry import project
from followspot.room import Camera, Room
from followspot.room_file import load, save
from followspot_room.calibration import read_calibration
from followspot_room.exporting import WRITABLE, format_of, write_calibration
from followspot_room.formats.camera_table import rotation_vector
from followspot_room.formats.svoboda import decompose
from followspot_room.formats.view import turned_clockwise

POINTS = np.random.default_rng(1).uniform([-0.6, -0.5, 2.0], [0.6, 0.5, 5.0], (40, 3))
"""In front of any camera of the tests, in its own coordinates, m."""


def between(low: float, high: float) -> Any:
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


@st.composite
def cameras(draw: st.DrawFn, name: str = "cam_0", k3: bool = True) -> Camera:
    turn = np.array([draw(between(-3.1, 3.1)) for _ in range(3)])
    f, a, cx, cy = (draw(between(*limits)) for limits in ((100, 3000), (0.9, 1.1), (50, 800), (50, 500)))
    lens = [draw(between(-0.3, 0.3)), draw(between(-0.1, 0.1))]
    lens += [draw(between(-0.01, 0.01)), draw(between(-0.01, 0.01)), draw(between(-0.1, 0.1)) if k3 else 0.0]
    return Camera(
        name=name,
        kind="color",
        size=(draw(st.integers(2, 4000)), draw(st.integers(2, 4000))),
        matrix=np.array([[f, 0, cx], [0, f * a, cy], [0, 0, 1]]),
        distortion=np.array(lens),
        rotation=cv2.Rodrigues(turn)[0],
        translation=np.array([draw(between(-20, 20)) for _ in range(3)]),
    )


def assert_same(a: Camera, b: Camera) -> None:
    assert (a.name, a.size, a.model) == (b.name, b.size, b.model)
    np.testing.assert_allclose(a.rotation, b.rotation, atol=1e-6)
    np.testing.assert_allclose(a.translation, b.translation, atol=1e-6)
    np.testing.assert_allclose(a.matrix, b.matrix, atol=1e-6)
    np.testing.assert_allclose(a.distortion, b.distortion, atol=1e-9)


@pytest.mark.parametrize("key", sorted(WRITABLE))
@given(data=st.data())
@settings(max_examples=25, deadline=None)
def test_written_cameras_are_read_back(
    key: str, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    k3 = key != "svoboda"
    written = [data.draw(cameras("left", k3)), data.draw(cameras("cam_7", k3))]
    for a, b in zip(written, back(tmp_path_factory.mktemp("x"), key, written), strict=True):
        assert_same(a, b)


@given(turn=st.tuples(*[between(-1.8, 1.8)] * 3))
@settings(max_examples=50, deadline=None)
def test_rotation_vector_is_exact_for_small_and_large_angles(turn: tuple[float, float, float]) -> None:
    for scale in (1.0, 1e-3, 1e-6):
        vector = scale * np.array(turn)
        np.testing.assert_allclose(rotation_vector(cv2.Rodrigues(vector)[0]), vector, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("key", ["anipose", "caliscope", "opencv"])
def test_fisheye_is_written_and_read_back(tmp_path: Path, key: str) -> None:
    lens = a_camera(model="fisheye", distortion=np.array([0.1, -0.02, 0.003, 0.001]))
    (read,) = back(tmp_path, key, [lens])
    assert_same(lens, read)


@pytest.mark.parametrize("key", ["qualisys", "svoboda"])
def test_fisheye_is_refused_where_the_format_has_none(tmp_path: Path, key: str) -> None:
    lens = a_camera(model="fisheye", distortion=np.zeros(4))
    with pytest.raises(InputError, match=r"camera left is a fisheye.*\n.*anipose or opencv"):
        write_calibration([lens], tmp_path / "x", WRITABLE[key])


@pytest.mark.parametrize("key", ["anipose", "caliscope", "qualisys", "svoboda"])
def test_a_rational_lens_is_refused_with_the_one_format_that_has_it(tmp_path: Path, key: str) -> None:
    lens = a_camera(model="rational", distortion=np.array([0.3, -0.1, 0, 0, 0.02, 0.6, -0.05, 0.01]))
    with pytest.raises(InputError, match=r"camera left is a rational.*\n +export it as opencv"):
        write_calibration([lens], tmp_path / "x", WRITABLE[key])


def test_what_a_format_cannot_hold_of_a_camera_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save(Room("r", {"left": a_camera(kind="infrared", clock_offset=0.01)}), tmp_path / "room.yaml")
    for name, said in (
        ("c.toml", "kinds of cameras and clock offsets have"),
        ("c.qca.txt", "clock offsets have"),
    ):
        assert main(["room", "export", str(tmp_path / "room.yaml"), "-o", str(tmp_path / name)]) == 0
        assert f"warning: {said} no place in" in capsys.readouterr().err


def test_opencv_reads_what_is_written_for_it(tmp_path: Path) -> None:
    camera = a_camera()
    write_calibration([camera], tmp_path / "x.yml", WRITABLE["opencv"])
    file = cv2.FileStorage(str(tmp_path / "x.yml"), cv2.FILE_STORAGE_READ)
    node = file.getNode("left")
    np.testing.assert_array_equal(node.getNode("camera_matrix").mat(), camera.matrix)
    np.testing.assert_array_equal(node.getNode("distortion_coefficients").mat()[0], camera.distortion)
    np.testing.assert_array_equal(node.getNode("T").mat()[:, 0], camera.translation)
    assert node.getNode("image_width").real() == 640


def test_what_opencv_writes_is_read(tmp_path: Path) -> None:
    K = a_camera().matrix
    for name in ("left", "right"):
        file = cv2.FileStorage(str(tmp_path / f"{name}.yml"), cv2.FILE_STORAGE_WRITE)
        file.write("image_width", 640)
        file.write("image_height", 480)
        file.write("camera_matrix", K)
        file.write("distortion_coefficients", np.array([[-0.2, 1e-5, 0, 0, 0]]))
        file.release()
    left, right = read_calibration(tmp_path).cameras
    assert (left.name, right.name, left.size) == ("left", "right", (640, 480))
    np.testing.assert_array_equal(left.matrix, K)
    np.testing.assert_array_equal(left.distortion, [-0.2, 1e-5, 0, 0, 0])


def test_skew_and_scale_and_sign_of_a_projection_matrix_do_not_matter() -> None:
    K = np.array([[500.0, 3.0, 320], [0, 510, 240], [0, 0, 1]])
    camera = a_camera(matrix=K)
    for scale in (1.0, -0.037, 210.0):
        own, R, t = decompose(scale * camera.projection)
        np.testing.assert_allclose(own, K, atol=1e-9)
        np.testing.assert_allclose(R, camera.rotation, atol=1e-12)
        np.testing.assert_allclose(t, camera.translation, atol=1e-9)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_turned_camera_sees_the_turned_picture(quarters: int) -> None:
    camera = a_camera()
    room = (POINTS - camera.translation) @ camera.rotation
    pixel = project(camera, room)
    for height in [480, 640, 480][:quarters]:
        pixel = np.column_stack([height - 1 - pixel[:, 1], pixel[:, 0]])
    turned = turned_clockwise(camera, quarters)
    np.testing.assert_allclose(project(turned, room), pixel, atol=1e-9)
    assert turned.size == ((480, 640) if quarters % 2 else (640, 480))


def test_view_rotation_makes_a_portrait_camera(tmp_path: Path) -> None:
    (turned,) = read_calibration(qualisys(tmp_path, viewrotation="90")).cameras
    assert_same(turned, turned_clockwise(a_camera(), 1))


def test_marker_cameras_of_qualisys_are_infrared(tmp_path: Path) -> None:
    (camera,) = back(tmp_path, "qualisys", [a_camera(kind="infrared")])
    assert camera.kind == "infrared"


@pytest.mark.parametrize(
    ("output", "key"),
    [
        ("a/camera_array.toml", "caliscope"),
        ("a.TOML", "anipose"),
        ("C.qca.txt", "qualisys"),
        ("a.yml", "opencv"),
    ],
)
def test_name_of_the_output_says_the_format(output: str, key: str) -> None:
    assert format_of(Path(output)) == key


def test_room_is_exported_and_imported_by_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    room = Room("r", {"left": a_camera()}, planes={"floor": np.array([0.0, 0, 1, 0])})
    save(room, tmp_path / "room.yaml")
    assert main(["room", "export", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "out/c.toml")]) == 0
    assert "planes have no place" in capsys.readouterr().err
    arguments = ["-o", str(tmp_path / "again.yaml"), "--infrared", "left"]
    assert main(["room", "import", str(tmp_path / "out/c.toml"), *arguments]) == 0
    again = load(tmp_path / "again.yaml").cameras["left"]
    assert (again.kind, again.source) == ("infrared", None)
    assert_same(again, a_camera())


def test_format_that_the_name_does_not_say_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["room", "export", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "selfcal")]) == 2
    assert "give --format" in capsys.readouterr().err
