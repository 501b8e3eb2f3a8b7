"""Cameras of a room, written for other programs and read back."""

import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.tools.exported import a_camera, back

from followspot.cli.main import main
from followspot.errors import InputError
from followspot.files import DATA
from followspot.geometry import project
from followspot.room import Camera, Room
from followspot.room_file import load, save
from followspot_room.calibration import FORMATS, read_calibration
from followspot_room.checks import Unfit
from followspot_room.exporting import WRITABLE, format_of, write_calibration
from followspot_room.formats.camera_table import rotation_vector
from followspot_room.formats.qualisys import parse as parse_qualisys
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


def qualisys(folder: Path, **replacements: str) -> Path:
    back(folder, "qualisys", [a_camera()])
    file = folder / "x.qca.txt"
    text = file.read_text()
    for old, new in replacements.items():
        text = re.sub(f'{old}="[^"]*"', f'{old}="{new}"', text)
    file.write_text(text)
    return file


def test_view_rotation_makes_a_portrait_camera(tmp_path: Path) -> None:
    (turned,) = read_calibration(qualisys(tmp_path, viewrotation="90")).cameras
    assert_same(turned, turned_clockwise(a_camera(), 1))


def test_marker_cameras_of_qualisys_are_infrared(tmp_path: Path) -> None:
    (camera,) = back(tmp_path, "qualisys", [a_camera(kind="infrared")])
    assert camera.kind == "infrared"


@pytest.mark.parametrize(
    ("replacements", "complaint"),
    [
        ({"viewrotation": "45"}, "camera left: viewrotation is '45'"),
        ({"r11": "3"}, "camera left is no rotation"),
        ({"x": "nan"}, "<transform> has a number that is not finite"),
        ({"focalLengthU": "-1"}, "intrinsic is no camera matrix"),
        ({"right": "1e9"}, "width is 1000000001, needs a number of pixels"),
        ({"serial": "../x"}, "has the name '../x'.*\n.*rename"),
    ],
)
def test_mistake_in_a_qualisys_file_is_told(
    tmp_path: Path, replacements: dict[str, str], complaint: str
) -> None:
    file = qualisys(tmp_path, **replacements)
    with pytest.raises(InputError, match=f"{file}: .*{complaint}"):
        read_calibration(file)


@pytest.mark.parametrize(
    "declaration", ['<!DOCTYPE x [<!ENTITY a "aaaa">]>', "<!doctype x>", '<! ENTITY a "b">']
)
def test_document_type_is_refused_before_the_xml_is_read(tmp_path: Path, declaration: str) -> None:
    file = tmp_path / "x.qca.txt"
    file.write_text(f"{declaration}<calibration><cameras>&a;</cameras></calibration>")
    with pytest.raises(InputError, match="has a DOCTYPE"):
        read_calibration(file)


TOML = """
[cam_0]
name = "left"
size = [640, 480]
matrix = [[500.0, 0.0, 320.0], [0.0, 510.0, 240.0], [0.0, 0.0, 1.0]]
distortions = [-0.2, 0.05, 0.003, -0.002]
rotation = [0.1, 0.2, 0.3]
translation = [0.0, 0.0, 1.0]
"""


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("[640, 480]", "[640]", r"camera left: size is \[640\], needs width and height"),
        ("[640, 480]", "[640, 4.5]", "height is 4.5, needs a number of pixels"),
        ("[0.1, 0.2, 0.3]", "[0.1, 0.2]", "rotation has shape"),
        ("[0.1, 0.2, 0.3]", "[0.1, nan, 0.3]", "rotation has a number that is not finite"),
        ("-0.002]", "-0.002, 0, 0]", "needs k1, k2, p1, p2 and k3, or eight coefficients\n.*thin-prism"),
        ("[0.0, 0.0, 1.0]\n", "7\n", "translation has shape"),
        ('"left"', '"a b"', "has the name 'a b'"),
        ("size =", "size ", "this is no TOML: .*line 4.*\n.*mend"),
    ],
)
def test_mistake_in_toml_is_told(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    assert old in TOML
    file = tmp_path / "calibration.toml"
    file.write_text(TOML.replace(old, new))
    with pytest.raises(InputError, match=f"{file}: .*{complaint}"):
        read_calibration(file)


def test_camera_that_caliscope_ignores_is_left_out_with_a_note(tmp_path: Path) -> None:
    table = TOML.replace("[cam_0]", "[cameras.{}]").replace('name = "left"', "")
    file = tmp_path / "camera_array.toml"
    file.write_text(table.format(0) + table.format(3) + "ignore = true\n[cameras.4]\nsize = [2, 2]\n")
    read = read_calibration(file)
    assert [camera.name for camera in read.cameras] == ["cam_0"]
    assert [note.split(" there")[0] for note in read.notes] == [
        "camera cam_3 is ignored",
        "camera cam_4 is not calibrated",
    ]


@pytest.mark.parametrize(
    ("file", "text", "complaint"),
    [
        ("Res.dat", "640\n", "Res.dat does not have width and height of camera 1\n.*752 480"),
        ("basename1.rad", "K11 = 3\n", "the .rad file of camera 1 has no K12"),
        ("camera1.Pmat.cal", "1 2 3 4\n", r"camera1.Pmat.cal has shape \(1, 4\)"),
        ("camera1.Pmat.cal", "1 2 3 4\n" * 3, "left 3x3 part is singular"),
        ("camera_order.txt", "\n", "camera_order.txt has 0 names"),
    ],
)
def test_mistake_in_a_svoboda_folder_names_the_file(
    tmp_path: Path, file: str, text: str, complaint: str
) -> None:
    back(tmp_path, "svoboda", [a_camera()])
    (tmp_path / "x" / file).write_text(text)
    with pytest.raises(InputError, match=complaint):
        read_calibration(tmp_path / "x")


def test_mistake_in_opencv_yaml_names_the_line(tmp_path: Path) -> None:
    back(tmp_path, "opencv", [a_camera()])
    file = tmp_path / "x.yml"
    file.write_text(file.read_text().replace("image_height: 480", "image_width: 480"))
    with pytest.raises(InputError, match=r'x.yml, line 5: the key "image_width" stands here twice'):
        read_calibration(file)
    file.write_text(file.read_text().replace("   image_width: 480\n", ""))
    with pytest.raises(InputError, match=r"camera left has no size\n.*image_height"):
        read_calibration(file)


def test_folder_larger_than_the_limit_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "points.yml").open("wb") as file:
        file.truncate(DATA + 1)
    with pytest.raises(InputError, match=f"larger than {DATA} bytes"):
        read_calibration(tmp_path)


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


def test_xml_without_cameras_is_another_format() -> None:
    assert parse_qualisys({"x": "<calibration><cameras/></calibration>"}) is None


@pytest.mark.parametrize("key", sorted(WRITABLE))
@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_damaged_file_is_read_or_refused_and_nothing_else(key: str, data: st.DataObject) -> None:
    write = WRITABLE[key].write
    assert write is not None
    files = dict(write([a_camera(), a_camera(name="cam_7")]))
    name = data.draw(st.sampled_from(sorted(files)))
    start = data.draw(st.integers(0, len(files[name])))
    end = data.draw(st.integers(start, min(start + 30, len(files[name]))))
    wrong = data.draw(
        st.sampled_from(["", "nan", "-1", "1e999", "[]", "{}", '"x"', "\n", "<a/>", "\0", "9" * 40])
    )
    files[name] = files[name][:start] + wrong + files[name][end:]
    for known in FORMATS:
        try:
            if known.parse(files) is not None:
                break
        except Unfit:
            break
