"""Rooms and scores of persons, as a user types them."""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from followspot import InputError
from followspot.cli.main import main
from followspot.cli.parser import build_parser
from followspot.geometry import project
from followspot.room_file import load
from followspot_room.calibration import read_calibration

PERSONS = dataset("persons-dev")
needs_recordings = needs_data("persons-dev")
LEVEL = [[0, -1, 0], [0, 0, -1], [1, 0, 0]]
PANORAMA = {
    "type": "cylinder",
    "width": 628,
    "height": 100,
    "F": 100,
    "u0": 313.5,
    "v0": 49.5,
    "position": [1, 2, 1],
}
PINHOLE = {
    "type": "pinhole",
    "width": 64,
    "height": 48,
    "K": [[50, 0, 31.5], [0, 50, 23.5], [0, 0, 1]],
    "R": LEVEL,
    "t": [0, 1.2, 0],
}
TRUE_HEAD = "time,person,x,y,z_head_top,r,torso_heading_room,torso_heading,head_pan,head_tilt,visible_upper\n"


@pytest.fixture
def recordings(tmp_path: Path) -> Path:
    """A calibration of two rooms, a folder of pictures per camera, and the truth."""
    (tmp_path / "calib.json").write_text(json.dumps({"around": PANORAMA, "left": PINHOLE, "right": PINHOLE}))
    for name, size in {"around": (100, 628), "left": (48, 64), "right": (48, 64)}.items():
        (tmp_path / name).mkdir()
        cv2.imwrite(str(tmp_path / name / "0.png"), np.zeros(size, "u1"))
        row = "0.0,1,2,0,1.7,2,0.0,3.1416,0,0,1\n"
        (tmp_path / f"{name}_gt.csv").write_text(TRUE_HEAD + row)
    return tmp_path


def import_room(folder: Path, *only: str) -> int:
    arguments = [str(folder / "calib.json"), "--videos", str(folder), "-o", str(folder / "room.yaml")]
    return main(["room", "import", *arguments, "--only", *only])


def calibration(folder: Path, **entries: Any) -> Path:
    path = folder / "calib.json"
    path.write_text(json.dumps(entries))
    return path


def test_panorama_looks_along_x_and_left_of_it_is_left_in_the_picture(tmp_path: Path) -> None:
    (camera,) = read_calibration(calibration(tmp_path, around=PANORAMA)).cameras
    assert (camera.model, camera.size) == ("cylinder", (628, 100))
    ahead, left, above = project(camera, np.array([[3.0, 2, 1], [1, 4, 1], [3, 2, 1.5]]))
    np.testing.assert_allclose(ahead, [313.5, 49.5])
    np.testing.assert_allclose(left, [313.5 - 100 * np.pi / 2, 49.5])
    np.testing.assert_allclose(above, [313.5, 49.5 - 25])


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"F": None}, "camera around of type cylinder lacks F"),
        ({"F": -3}, "camera around: F is no camera matrix"),
        ({"position": [0, 0]}, r"position has shape \(2,\), needs \(3,\)"),
        ({"width": 0}, "camera around: width is 0"),
    ],
)
def test_mistake_names_camera_and_field(tmp_path: Path, change: dict[str, Any], complaint: str) -> None:
    entry = {key: value for key, value in {**PANORAMA, **change}.items() if value is not None}
    with pytest.raises(InputError, match=complaint):
        read_calibration(calibration(tmp_path, around=entry))


def test_camera_with_a_bad_name_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"has the name '\.\./up'"):
        read_calibration(calibration(tmp_path, **{"../up": PINHOLE}))


def test_type_that_is_not_known_is_no_calibration(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no calibration in a known format"):
        read_calibration(calibration(tmp_path, around={**PANORAMA, "type": "mirror"}))


def test_one_camera_of_several_rooms_becomes_a_room_with_its_truth(
    recordings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert import_room(recordings, "around") == 0
    room = load(recordings / "room.yaml")
    assert list(room.cameras) == ["around"]
    assert room.truth is not None
    assert (room.truth.uses, room.truth.params["path"]) == ("cameras.pose_truth_csv", "around_gt.csv")
    assert "next: followspot run GRAPH --room" in capsys.readouterr().out


def test_truth_of_several_cameras_is_that_of_their_folder(recordings: Path) -> None:
    assert import_room(recordings, "left", "right") == 0
    room = load(recordings / "room.yaml")
    assert list(room.cameras) == ["left", "right"]
    assert room.truth is not None
    assert room.truth.params["path"] == "."


def test_an_option_that_takes_several_names_may_be_given_several_times(recordings: Path) -> None:
    assert (
        import_room(recordings, "left", "--only", "right", "--infrared", "left", "--infrared", "right") == 0
    )
    room = load(recordings / "room.yaml")
    assert {name: camera.kind for name, camera in room.cameras.items()} == {
        "left": "infrared",
        "right": "infrared",
    }


def options(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """The options of a command and of its commands."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from options(command)
        elif action.option_strings:
            yield action


def test_no_option_of_any_command_keeps_only_the_last_of_several_lists() -> None:
    lists = [action for action in options(build_parser()) if action.nargs in ("+", "*")]
    assert len(lists) >= 3
    assert {type(action).__name__ for action in lists} == {"_ExtendAction"}


def test_camera_that_is_not_there_is_asked_back(recordings: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert import_room(recordings, "lefd") == 2
    said = capsys.readouterr().err
    assert '--only: there is no camera "lefd"' in said
    assert 'did you mean "left"' in said


def poses(folder: Path, camera: str = "") -> Path:
    path = folder / "poses.csv"
    heading = "0" if camera == "fused" else "3.1416"
    name = "" if camera == "fused" else camera
    path.write_text(
        "frame,time,person,x,y,z_head_top,torso_heading,head_pan,head_tilt,camera\n"
        f"0,0.0,4,2.1,0,1.75,{heading},0,0,{name}\n"
    )
    return path


def test_poses_are_told_by_their_header_and_scored(
    recordings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["score", str(poses(recordings, "left")), str(recordings / "left_gt.csv")]
    assert main([*arguments, "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)["all"]
    assert whole["distance_m"]["mean"] == pytest.approx(0.1)
    assert whole["height_cm"]["mean"] == pytest.approx(5)
    assert whole["torso"]["median_deg"] < 0.01
    assert main(arguments) == 0
    assert "height: mean ± sigma" in capsys.readouterr().out


def test_fused_poses_are_scored_against_the_truth_of_every_camera(
    recordings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = [str(recordings / f"{name}_gt.csv") for name in ("left", "right")]
    assert main(["score", str(poses(recordings, "fused")), *truth, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["1"]["torso"]["median_deg"] == 0
    assert main(["score", str(poses(recordings, "left")), *truth]) == 2
    assert "has poses relative to one camera left" in capsys.readouterr().err


def test_plots_are_pictures_of_errors_and_ways(recordings: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    arguments = ["score", str(poses(recordings, "left")), str(recordings / "left_gt.csv")]
    assert main([*arguments, "--plot", str(recordings / "pictures")]) == 0
    assert "pose_errors.svg" in capsys.readouterr().out
    assert "error of torso heading, deg" in (recordings / "pictures/pose_errors.svg").read_text()
    assert "reported" in (recordings / "pictures/floor_plan.svg").read_text()


@needs_recordings
def test_recorded_boxes_of_upper_bodies_hold_their_heads() -> None:
    """The imported cameras project the middle of each head to where the recordings say it is."""
    import csv

    for camera in read_calibration(PERSONS / "calib.json").cameras:
        with (PERSONS / f"{camera.name}_gt.csv").open() as file:
            rows = [row for row in csv.DictReader(file) if float(row["visible_upper"]) == 1]
        xyz, low, high = (
            np.array([[float(row[name]) for name in names] for row in rows])
            for names in (("headc_x", "headc_y", "headc_z"), ("ux0", "uy0"), ("ux1", "uy1"))
        )
        pixel = project(camera, xyz)
        turns = 2 * np.pi * camera.matrix[0, 0] * (camera.model == "cylinder")
        pixel[:, 0] += turns * np.rint(((low + high)[:, 0] / 2 - pixel[:, 0]) / (turns or np.inf))
        assert ((pixel > low) & (pixel < high)).all()
