"""`followspot room import` of a room file: the same room with other recordings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from followspot import Camera, Room
from followspot.cli.main import main
from followspot.room import Sensor, StageUse, Target
from followspot.room_file import load, save


def camera(name: str, x: float) -> Camera:
    eye = np.eye(3)
    known = Camera(
        name,
        "color",
        (64, 48),
        50 * eye + [[0, 0, 32], [0, 0, 24], [0, 0, -49]],
        np.zeros(5),
        eye,
        eye[0] * x,
    )
    source = StageUse("cameras.images", {"path": f"monday/{name}", "fps": 25})
    return replace(known, source=source, clock_offset=0.01, tags={"zone": ("left",)})


def recorded(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).mkdir(parents=True)
        cv2.imwrite(str(folder / name / "0.png"), np.zeros((48, 64), "u1"))


def monday(folder: Path) -> Room:
    room = Room(
        "monday",
        {name: camera(name, x) for name, x in (("a", 1.0), ("b", 2.0))},
        {"floor": np.array([0.0, 0, 1, 0])},
        {"red": Target("red", 0.05)},
        StageUse("cameras.truth_csv", {"path": "monday/truth.csv"}),
        {"imu0": Sensor("imu0", "imu", StageUse("imu.csv", {"path": "monday/imu.csv"}), rate=100.0)},
        {"hall.similarity": 0.85},
    )
    save(room, folder / "monday.yaml")
    return room


def test_the_same_room_gets_other_recordings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old = monday(tmp_path)
    recorded(tmp_path / "tuesday", "a", "b")
    out = tmp_path / "rooms/tuesday.yaml"
    command = ["room", "import", str(tmp_path / "monday.yaml"), "--videos", str(tmp_path / "tuesday")]
    assert main([*command, "-o", str(out)]) == 0
    new = load(out)
    assert new.name == "tuesday"
    assert [c.source and c.source.params for c in new.cameras.values()] == [
        {"path": "../tuesday/a"},
        {"path": "../tuesday/b"},
    ]
    for name, camera in new.cameras.items():
        assert (camera.clock_offset, camera.tags) == (0.01, {"zone": ("left",)})
        np.testing.assert_array_equal(camera.translation, old.cameras[name].translation)
    assert (list(new.planes), list(new.targets), list(new.sensors)) == (["floor"], ["red"], ["imu0"])
    assert new.tune == {"hall.similarity": 0.85}
    assert new.truth is None
    assert new.sensors["imu0"].source is None
    assert "sensors without a source: imu0" in capsys.readouterr().err


def test_a_file_that_is_there_is_replaced_only_if_the_new_one_is_made_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monday(tmp_path)
    file, other = tmp_path / "monday.yaml", tmp_path / "work.yaml"
    other.write_text("# an evening of work\n")
    commands = [
        ["import", str(file), "-o"],
        ["rectify", str(file), "-o"],
        ["guess", str(tmp_path / "street.avi"), "-o"],
        ["export", str(file), "-o"],
    ]
    for command in commands:
        assert main(["room", *command, str(other)]) == 2
        assert "work.yaml is there already\n    name another file, or remove it" in capsys.readouterr().err
    assert other.read_text() == "# an evening of work\n"
    assert main(["room", "import", str(file), "--only", "b", "-o", str(file)]) == 0
    assert list(load(file).cameras) == ["b"]


def test_templates_have_the_areas_of_larger_recordings(tmp_path: Path) -> None:
    room = monday(tmp_path)
    red = Target("red", 0.05, area={"a": (3.0, 70.0), "b": (4.0, 80.0)})
    save(replace(room, targets={"red": red}), tmp_path / "monday.yaml")
    recorded(tmp_path / "tuesday", "a", "b")
    cv2.imwrite(str(tmp_path / "tuesday/a/0.png"), np.zeros((96, 128), "u1"))
    out = tmp_path / "tuesday.yaml"
    command = ["room", "import", str(tmp_path / "monday.yaml"), "--videos", str(tmp_path / "tuesday")]
    assert main([*command, "-o", str(out)]) == 0
    assert load(out).targets["red"].area == {"a": (12.0, 280.0), "b": (4.0, 80.0)}


def test_some_cameras_take_their_part_of_the_templates_with_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room = monday(tmp_path)
    red = Target("red", 0.05, area={"a": (3.0, 70.0), "b": (4.0, 80.0)})
    save(replace(room, targets={"red": red}), tmp_path / "monday.yaml")
    out = tmp_path / "part.yaml"
    command = ["room", "import", str(tmp_path / "monday.yaml"), "--only"]
    assert main([*command, "b", "-o", str(out)]) == 0
    assert list(load(out).cameras) == ["b"]
    assert load(out).targets["red"].area == {"b": (4.0, 80.0)}
    assert main([*command, "c", "-o", str(tmp_path / "none.yaml")]) == 2
    assert "--only" in capsys.readouterr().err


def test_a_mistake_in_the_room_file_is_told_at_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monday(tmp_path)
    file = tmp_path / "monday.yaml"
    file.write_text(file.read_text().replace("kind: color", "kind: 7", 1))
    assert main(["room", "import", str(file), "-o", str(tmp_path / "new.yaml")]) == 2
    assert "monday.yaml:4:" in capsys.readouterr().err
    assert not (tmp_path / "new.yaml").exists()
