"""`room import`, `calibrate targets` and `score` as a user types them."""

import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from followspot.cli.main import main
from followspot.room_file import load

SIZE = (160, 120)
GLOWBALLS = dataset("glowballs-dev")
needs_recordings = needs_data("glowballs-dev")


def camera(name: str, kind: str) -> dict[str, object]:
    return {
        "name": name,
        "kind": kind,
        "width": SIZE[0],
        "height": SIZE[1],
        "K": [[150, 0, 80], [0, 150, 60], [0, 0, 1]],
        "dist": [0] * 5,
        "R": np.eye(3).tolist(),
        "t": [0, 0, 3],
    }


def film(path: Path, color: tuple[int, int, int] | None, frames: int = 12) -> None:
    """A glowing disc that moves through the dark; None: darkness."""
    path.parent.mkdir(parents=True, exist_ok=True)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30, SIZE)
    for number in range(frames):
        picture = np.zeros((SIZE[1], SIZE[0], 3), "u1")
        if color is not None:
            cv2.circle(picture, (20 + 10 * number, 60), 5, color, -1)
        writer.write(picture)
    writer.release()


@pytest.fixture
def studio(tmp_path: Path) -> Path:
    """A calibration, one recording per camera with truth, and clips of two targets."""
    document = {
        "cameras": [camera("left", "color"), camera("right", "ir")],
        "planes": {"floor": [0, 0, 1, 0]},
    }
    (tmp_path / "calibration.json").write_text(json.dumps(document))
    for name in ("left", "right"):
        film(tmp_path / f"take/{name}.mkv", (0, 0, 250), frames=3)
    (tmp_path / "take/truth.csv").write_text("frame,time,object,x,y,z,hidden,trackable,pair\n")
    for target, color in (("red", (0, 0, 250)), ("green", (0, 250, 0))):
        film(tmp_path / f"clips/{target}/left.mkv", color)
        film(tmp_path / f"clips/{target}/right.mkv", (200, 200, 200))
    return tmp_path


def import_room(studio: Path, *more: str) -> int:
    room = str(studio / "rooms/studio.yaml")
    return main(
        [
            "room",
            "import",
            str(studio / "calibration.json"),
            "--videos",
            str(studio / "take"),
            "-o",
            room,
            *more,
        ]
    )


def calibrate(studio: Path, *more: str) -> int:
    room = str(studio / "rooms/studio.yaml")
    return main(["calibrate", "targets", "--room", room, "--clips", str(studio / "clips"), *more])


@pytest.mark.parametrize("command", ["room import", "calibrate targets", "score"])
def test_help_shows_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main([*command.split(), "--help"])
    assert f"\n  followspot {command} " in capsys.readouterr().out


def test_imported_room_has_cameras_sources_planes_and_truth(
    studio: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert import_room(studio) == 0
    assert "1 color and 1 infrared cameras, planes floor, with truth" in capsys.readouterr().out
    room = load(studio / "rooms/studio.yaml")
    assert room.name == "studio"
    assert {name: c.kind for name, c in room.cameras.items()} == {"left": "color", "right": "infrared"}
    source = room.cameras["left"].source
    assert source is not None
    assert (source.uses, source.params["path"]) == ("cameras.video", "../take/left.mkv")
    assert room.truth is not None
    assert (room.truth.uses, room.truth.params["path"]) == ("cameras.truth_csv", "../take/truth.csv")


def test_missing_recording_names_the_camera_and_can_be_allowed(
    studio: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (studio / "take/right.mkv").unlink()
    assert import_room(studio) == 2
    assert "camera right has no recording" in capsys.readouterr().err
    assert not (studio / "rooms/studio.yaml").exists()
    assert import_room(studio, "--allow-missing", "--json") == 0
    printed = capsys.readouterr()
    assert "camera right has no recording" in printed.err
    assert json.loads(printed.out)["missing"] == ["right"]
    assert load(studio / "rooms/studio.yaml").cameras["right"].source is None


def test_folder_of_pictures_is_a_source_too(studio: Path) -> None:
    (studio / "take/left.mkv").unlink()
    (studio / "take/left").mkdir()
    assert import_room(studio) == 0
    source = load(studio / "rooms/studio.yaml").cameras["left"].source
    assert source is not None
    assert (source.uses, source.params["path"]) == ("cameras.images", "../take/left")


def test_templates_are_learnt_and_written_into_the_room(
    studio: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import_room(studio)
    assert calibrate(studio, "--radius", "0.05") == 0
    targets = load(studio / "rooms/studio.yaml").targets
    assert list(targets) == ["green", "red"]
    red = targets["red"]
    assert red.radius == 0.05
    assert list(red.hue_histogram) == ["left"]
    assert red.hue_histogram["left"][[0, 15]].sum() == pytest.approx(1)
    assert targets["green"].hue_histogram["left"][5] == pytest.approx(1)
    low, high = red.gray["right"]
    assert low < 200 <= high
    smallest, largest = red.area["left"]
    assert 50 < smallest <= largest < 110
    rows = [line.split()[:3] for line in capsys.readouterr().out.splitlines()]
    assert ["red", "right", "12"] in rows


def test_targets_without_clips_and_known_radii_stay(studio: Path) -> None:
    import_room(studio)
    calibrate(studio, "--radius", "0.05")
    before = load(studio / "rooms/studio.yaml").targets["green"]
    for clip in (studio / "clips/green").iterdir():
        clip.unlink()
    (studio / "clips/green").rmdir()
    assert calibrate(studio) == 0
    after = load(studio / "rooms/studio.yaml").targets
    assert list(after) == ["green", "red"]
    assert after["red"].radius == 0.05
    np.testing.assert_array_equal(after["green"].hue_histogram["left"], before.hue_histogram["left"])


def test_dark_clip_is_a_warning_with_target_camera_and_remedy(
    studio: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import_room(studio)
    film(studio / "clips/red/left.mkv", None)
    (studio / "clips/green/right.mkv").unlink()
    assert calibrate(studio, "--json") == 0
    printed = capsys.readouterr()
    assert "warning: red, left:" in printed.err
    assert "move the target through the camera's view" in printed.err
    assert f"warning: green, right: there is no clip {studio}/clips/green/right.mkv" in printed.err
    assert list(load(studio / "rooms/studio.yaml").targets["red"].area) == ["right"]


def test_target_that_no_camera_saw_fails_and_leaves_the_others(
    studio: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import_room(studio)
    for name in ("left", "right"):
        film(studio / f"clips/red/{name}.mkv", None)
    assert calibrate(studio) == 1
    assert "no camera saw red" in capsys.readouterr().err
    assert list(load(studio / "rooms/studio.yaml").targets) == ["green"]


def test_empty_clips_folder_and_wrong_radius_are_input_errors(
    studio: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import_room(studio)
    assert calibrate(studio, "--radius", "-1") == 2
    assert (
        main(["calibrate", "targets", "--room", str(studio / "rooms/studio.yaml"), "--clips", "/none"]) == 2
    )
    assert "has no folder per target" in capsys.readouterr().err


def test_score_prints_a_table_or_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tracks, truth = tmp_path / "tracks.csv", tmp_path / "truth.csv"
    tracks.write_text("frame,time,object,state,x,y,z\n0,0,red,tracked,1,2,3\n1,0.1,red,tracked,1,2,3.01\n")
    truth.write_text(
        "frame,time,object,x,y,z,hidden,trackable,pair\n0,0,red,1,2,3,0,1,1\n1,0.1,red,1,2,3,0,1,1\n"
    )
    assert main(["score", str(tracks), str(truth)]) == 0
    assert "100.0 %" in capsys.readouterr().out
    assert main(["score", str(tracks), str(truth), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["red"]["median_mm"] == pytest.approx(5)
    assert main(["score", str(tracks), str(tmp_path / "none.csv")]) == 2


@pytest.mark.parametrize(
    ("name", "time", "told"), [("rot", 0, "red has|has rot"), ("red", 100, "has 100 to 100 s.*0 to 0.1 s")]
)
def test_tracks_and_truth_that_have_nothing_in_common_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, time: float, told: str
) -> None:
    tracks, truth = tmp_path / "tracks.csv", tmp_path / "truth.csv"
    tracks.write_text(f"frame,time,object,state,x,y,z\n0,{time},{name},tracked,1,2,3\n")
    truth.write_text(
        "frame,time,object,x,y,z,hidden,trackable,pair\n0,0,red,1,2,3,0,1,1\n1,0.1,red,1,2,3,0,1,1\n"
    )
    assert main(["score", str(tracks), str(truth)]) == 2
    assert re.search(told, capsys.readouterr().err)
    tracks.write_text("frame,time,object,state,x,y,z\n")
    assert main(["score", str(tracks), str(truth)]) == 0, "a run that tracks nothing has a score"


@needs_recordings
@pytest.mark.thorough
def test_shared_recording_becomes_a_room_with_all_templates(tmp_path: Path) -> None:
    room = str(tmp_path / "room.yaml")
    calibration, videos = str(GLOWBALLS / "calibration.json"), str(GLOWBALLS / "dev1")
    assert main(["room", "import", calibration, "--videos", videos, "-o", room]) == 0
    assert main(["calibrate", "targets", "--room", room, "--clips", str(GLOWBALLS / "templates")]) == 0
    targets = load(room).targets
    assert sorted(targets) == ["blue", "cyan", "green", "magenta", "red", "yellow"]
    for target in targets.values():
        assert len(target.hue_histogram) == len(target.gray) == 3
        assert len(target.area) == 6
        assert target.radius == 0.0762
    source = load(room).cameras["cam4"].source
    assert source is not None
    assert (tmp_path / source.params["path"]).resolve() == (GLOWBALLS / "dev1/cam4.mkv").resolve()
