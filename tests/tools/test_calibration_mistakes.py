"""Calibration files with mistakes: each is named, and damaged files are read or refused."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.tools.exported import a_camera, back
from tests.tools.qualisys_file import qualisys

from followspot.errors import InputError
from followspot.files import DATA
from followspot_room.calibration import FORMATS, read_calibration
from followspot_room.checks import Unfit
from followspot_room.exporting import WRITABLE
from followspot_room.formats.qualisys import parse as parse_qualisys


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
