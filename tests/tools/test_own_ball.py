"""A newcomer's own ball in his own video: a room, a click, a run, a drawn video."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.tools.own_ball import (
    FRAMES,
    GRAPH,
    RADIUS,
    RED,
    SIZE,
    middle,
    pick,
    picture,
    room_for,
)

from followspot import room_file
from followspot.cli.main import main
from followspot.errors import InputError
from followspot_balls.detection.hue import bhattacharyya
from followspot_balls.templates.from_picture import template_of
from followspot_calibrate.targets.pick_command import read_pick

THROWS = dataset("balls-thrown-room")


def test_own_ball_in_own_video(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    room = room_for(tmp_path)
    assert pick(room, "red") == 0
    shown = cv2.imread(str(tmp_path / "room.cam0.png"))
    assert shown.shape[1::-1] == SIZE
    x, y = middle(FRAMES // 2)
    assert f"--room {room} --pick red=X,Y" in capsys.readouterr().out
    assert pick(room, f"red={x},{y}", "blue=30,30") == 0
    assert "if paler things of its hue are found, skin or wood: --set color.min" in capsys.readouterr().out
    out = tmp_path / "out"
    assert main(["run", GRAPH, "--room", room, "--out", str(out)]) == 0
    with (out / "blobs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["frame"]) for row in rows if row["target"] == "red"] == list(range(FRAMES))
    for row in rows:
        wanted = middle(int(row["frame"])) if row["target"] == "red" else (30, 30)
        assert np.hypot(float(row["u"]) - wanted[0], float(row["v"]) - wanted[1]) < 1.0
    drawn = cv2.VideoCapture(str(out / "drawn/cam0.mp4"))
    assert drawn.get(cv2.CAP_PROP_FRAME_COUNT) == FRAMES
    drawn.release()


def test_a_click_and_a_rectangle_learn_the_same_ball() -> None:
    x, y = middle(3)
    clicked = template_of(picture(3), read_pick(f"red={x},{y}"))
    width = 2 * RADIUS + 1
    drawn = template_of(picture(3), read_pick(f"red={x - RADIUS},{y - RADIUS},{width},{width}"))
    assert clicked.pixels == pytest.approx(np.pi * (RADIUS + 0.5) ** 2, rel=0.05)
    assert drawn.pixels == pytest.approx(clicked.pixels, rel=0.05)
    assert bhattacharyya(clicked.histogram, drawn.histogram) > 0.95
    low, high = clicked.area
    assert (low, high) == (pytest.approx(clicked.pixels / 4, abs=0.06), clicked.pixels * 4)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("red=100,10", "runs over into what is beside"),
        ("red=100,10,20,20", "hardly any colour"),
        ("red=300,10", "not in the picture of 200 x 150 px"),
        ("red=190,140,20,20", "not in the picture"),
        ("red=1,2,3", "names no place in a picture"),
        ("=1,2", "names no place in a picture"),
    ],
)
def test_a_pick_that_shows_no_ball_says_why(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        template_of(picture(0), read_pick(text))


def test_a_pale_ball_asks_for_no_saturation() -> None:
    x, y = middle(3)
    pale = cv2.addWeighted(picture(3), 0.5, np.full((SIZE[1], SIZE[0], 3), 120, np.uint8), 0.5, 0)
    assert template_of(pale, read_pick(f"red={x},{y}")).minimum_saturation is None
    strong = template_of(picture(3), read_pick(f"red={x},{y}"))
    assert strong.minimum_saturation == int(0.8 * strong.saturation) > 150


def test_a_click_that_runs_over_into_a_hand_is_refused_and_a_highlight_is_not() -> None:
    x, y = middle(3)
    shiny = picture(3)
    cv2.circle(shiny, (x - 3, y - 3), 3, (255, 255, 255), -1)
    assert template_of(shiny, read_pick(f"red={x + 3},{y + 3}")).pixels > 250
    held = picture(3)
    cv2.line(held, (x, y), (x + 40, y + 30), RED, 8)
    with pytest.raises(InputError, match="runs over into what is beside the ball") as refused:
        template_of(held, read_pick(f"red={x},{y}"))
    assert "red=X,Y,WIDTH,HEIGHT" in str(refused.value)


def test_what_other_targets_and_cameras_know_stays_and_likeness_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    room = room_for(tmp_path)
    x, y = middle(0)
    assert pick(room, f"red={x},{y}@0") == 0
    before = room_file.load(room).targets["red"]
    capsys.readouterr()
    x, y = middle(5)
    words = ["--room", room, "--pick", f"ruby={x},{y}@5", "--radius", "0.05", "--json"]
    assert main(["calibrate", "targets", *words]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [pair[:2] for pair in told["alike"]] == [["ruby", "red"]]
    targets = room_file.load(room).targets
    assert np.array_equal(targets["red"].hue_histogram["cam0"], before.hue_histogram["cam0"])
    assert (targets["red"].radius, targets["ruby"].radius) == (before.radius, 0.05)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["room", "new", "-o", "FOLDER/new.yaml"], "neither a video nor a webcam"),
        (["room", "new", "--video", "FOLDER/no.mp4", "-o", "FOLDER/new.yaml"], "there is no video"),
        (["room", "new", "--video", "0", "-o", "FOLDER/new.yaml"], "a webcam is --webcam 0"),
        (["room", "new", "--video", "FOLDER/balls.avi", "-o", "FOLDER/room.yaml"], "is there already"),
        (["room", "new", "--webcam", "0", "--size", "wide", "-o", "FOLDER/new.yaml"], "--size wide"),
        (["run", GRAPH, "--room", "FOLDER/balls.avi"], "room new --video FOLDER/balls.avi -o room.yaml"),
        (["run", "FOLDER/balls.avi"], "is a video, not a graph, room or placement"),
        (["calibrate", "targets", "--room", "FOLDER/room.yaml", "--pick", "red@99"], "it has 12, counted"),
        (
            ["calibrate", "targets", "--room", "FOLDER/room.yaml", "--pick", "red=9,9", "--pick", "red=8,8"],
            "--pick red is given twice",
        ),
        (
            ["calibrate", "targets", "--room", "FOLDER/room.yaml", "--pick", "red=9,9", "--pick", "blue"],
            "--pick blue has no place",
        ),
        (
            ["calibrate", "targets", "--room", "FOLDER/room.yaml", "--pick", "red=9,9", "--radius", "0"],
            "--radius 0 is no radius of a target in metres",
        ),
        (
            ["calibrate", "targets", "--room", "FOLDER/room.yaml", "--clips", "FOLDER", "--radius", "76.2"],
            "--radius 76.2 is no radius of a target in metres",
        ),
        (
            ["calibrate", "targets", "--room", "FOLDER/room.yaml", "--pick", "red", "--camera", "cam1"],
            'there is no camera "cam1"',
        ),
    ],
)
def test_what_a_newcomer_gets_wrong_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    room_for(tmp_path)
    assert main([word.replace("FOLDER", str(tmp_path)) for word in words]) == 2
    assert said.replace("FOLDER", str(tmp_path)) in capsys.readouterr().err


def test_help_says_that_a_room_file_that_is_there_stays(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["room", "new", "--help"])
    assert "an old file is refused" in " ".join(capsys.readouterr().out.split())


def test_a_webcam_makes_a_room(tmp_path: Path) -> None:
    room = tmp_path / "desk.yaml"
    assert main(["room", "new", "--webcam", "0", "--size", "320x240", "-o", str(room)]) == 0
    camera = room_file.load(room).cameras["cam0"]
    assert camera.size == (320, 240)
    assert camera.source is not None
    assert camera.source.uses == "cameras.device"
    assert camera.source.params == {"device": 0}
    assert main(["check", GRAPH, "--room", str(room)]) == 0


@needs_data("balls-thrown-room")
def test_a_clicked_ball_is_found_in_a_real_throw(tmp_path: Path) -> None:
    """40 frames around the top of a throw, learnt by a click in one: as good as a template by hand."""
    room = tmp_path / "room.yaml"
    assert main(["room", "new", "--video", str(THROWS), "-o", str(room)]) == 0
    text = room.read_text()
    assert "with: {path: " in text
    room.write_text(text.replace("with: {path: ", "with: {start_frame: 192, frames: 40, path: "))
    assert pick(str(room), "red=352,122@19") == 0
    assert main(["run", GRAPH, "--room", str(room), "--out", str(tmp_path / "out")]) == 0
    with (tmp_path / "out/blobs.csv").open() as file:
        rows = list(csv.DictReader(file))
    frame = np.array([int(row["frame"]) for row in rows])
    assert frame.tolist() == list(range(192, 232))
    for axis in ("u", "v"):
        place = np.array([float(row[axis]) for row in rows])
        residual = place - np.polyval(np.polyfit(frame, place, 2), frame)
        assert np.sqrt(np.mean(residual**2)) < 1.0
