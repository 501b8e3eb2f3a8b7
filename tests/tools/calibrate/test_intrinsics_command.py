"""`calibrate intrinsics` as a user types it, and what it writes into a room file."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.tools.calibrate.drawn_boards import Photographer, lens, places
from tests.tools.calibrate.intrinsics_command import BOARD, SIZE, intrinsics

from followspot.room import Room
from followspot.room_file import load, save


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Pictures of a board in one camera."""
    folder, photographer = tmp_path_factory.mktemp("cam0"), Photographer(lens(), BOARD)
    for number, place in enumerate(places(0.42, (0.35, 0.25), 10)):
        cv2.imwrite(str(folder / f"{number}.png"), photographer.picture(place))
    return folder


@pytest.fixture
def boards(tmp_path: Path, pictures: Path) -> Path:
    """A folder with the pictures of one camera."""
    (tmp_path / "boards").mkdir()
    (tmp_path / "boards/cam0").symlink_to(pictures)
    return tmp_path


def test_command_makes_a_room_file(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert intrinsics(boards, "--videos", str(boards / "boards"), "--json") == 0
    answer = json.loads(capsys.readouterr().out)["cam0"]
    camera = load(boards / "room.yaml").cameras["cam0"]
    assert (camera.size, camera.model, camera.kind) == (SIZE, "pinhole", "color")
    np.testing.assert_array_equal(camera.matrix, answer["matrix"])
    assert answer["rms_px"] < 0.15
    assert len(answer["views"]) == 10
    assert answer["coverage"]["share"] > 0.4


def test_command_replaces_the_lens_and_nothing_else(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = lens(kind="infrared", translation=np.array([1.0, 2.0, 3.0]), host="pc", size=(320, 240))
    save(Room("r", {"cam0": before, "cam1": lens(name="cam1")}), boards / "room.yaml")
    text = (boards / "room.yaml").read_text()
    (boards / "room.yaml").write_text(f"# mine\n{text}")
    assert intrinsics(boards, "--clip", f"cam0={boards / 'boards/cam0'}") == 0
    after = load(boards / "room.yaml").cameras
    np.testing.assert_array_equal(after["cam0"].translation, [1, 2, 3])
    np.testing.assert_array_equal(after["cam1"].matrix, lens().matrix)
    assert (after["cam0"].kind, after["cam0"].host, after["cam0"].size) == ("infrared", "pc", SIZE)
    assert (boards / "room.yaml").read_text().startswith("# mine\n")
    told = capsys.readouterr()
    assert "cam0: its pose was found with another lens" in told.err
    assert f"the page to look at: {boards / 'room.intrinsics.html'}" in told.out
    page = (boards / "room.intrinsics.html").read_text()
    assert "cam0: its pose was found with another lens" in page
    assert "10 of 10" in page


def test_command_names_the_camera_without_a_board(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (boards / "boards/cam1").mkdir()
    cv2.imwrite(str(boards / "boards/cam1/0.png"), np.zeros((480, 640), "u1"))
    assert intrinsics(boards, "--videos", str(boards / "boards")) == 1
    error = capsys.readouterr().err
    assert "cam1: 0 usable views of the board, at least 3 are needed (1 pictures searched)" in error
    assert list(load(boards / "room.yaml").cameras) == ["cam0"]


def test_command_asks_for_the_board_if_the_search_for_a_lens_runs_away(
    boards: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("followspot_calibrate.intrinsics.calibration.MOST_DISTORTION", 1e-9)
    assert intrinsics(boards, "--videos", str(boards / "boards")) == 1
    error = capsys.readouterr().err
    assert "cam0: no lens explains the views" in error
    assert "is --board charuco:7x5:0.04:DICT_4X4_50 right?" in error
    assert not (boards / "room.yaml").exists()


def test_command_takes_the_chosen_cameras_only(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clip = str(boards / "boards/cam0")
    clips = ["--clip", f"left={clip}", "--clip", f"right={clip}"]
    assert intrinsics(boards, *clips, "--camera", "middle") == 2
    assert "--camera middle: no pictures of it are given" in capsys.readouterr().err
    assert intrinsics(boards, "--videos", str(boards / "boards"), "--camera", "cam0", "cam1") == 2
    assert "--camera cam1: no pictures of it are given" in capsys.readouterr().err
    assert not (boards / "room.yaml").exists()
    assert intrinsics(boards, *clips, "--camera", "right") == 0
    assert list(load(boards / "room.yaml").cameras) == ["right"]


def test_command_takes_one_recording_of_a_camera(boards: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clip = f"cam0={boards / 'boards/cam0'}"
    assert intrinsics(boards, "--clip", clip, "--clip", clip) == 2
    assert "cam0 has another recording" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--live", "--videos", "x"], "or live cameras (--live, --device), one of them"),
        (["--device", "cam0"], "--device cam0 is no CAMERA=DEVICE"),
        (["--device", "cam0=0", "--size", "big"], "--size big is no WIDTHxHEIGHT"),
        (["--live"], "has no cameras"),
        ([], "give recordings"),
        (["--live", "--camera", "x"], 'has no camera "x"'),
        (["--videos", "nowhere"], "nowhere is not a folder"),
        (["--clip", "cam0"], "--clip cam0: this is no CAMERA=PATH"),
        (["--clip", "cam0=nowhere"], "nowhere is not there"),
        (["--videos", "x", "--pictures", "0"], "--pictures 0 is less than 1"),
    ],
)
def test_command_refuses_what_it_cannot_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], complaint: str
) -> None:
    assert intrinsics(tmp_path, *arguments) == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "room.yaml").exists()
