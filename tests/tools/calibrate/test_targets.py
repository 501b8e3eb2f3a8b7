"""`calibrate targets` with people in view, and targets that look alike."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.plugins.balls.scene import learn_color

from followspot import Camera, Context, Room, Target
from followspot.cli.main import main
from followspot.messages import Array
from followspot.room_file import load, save
from followspot.tracking import Frame
from followspot_balls.color_blobs import ColorBlobs
from followspot_balls.detection.hue import bhattacharyya
from followspot_balls.templates.from_clip import ColorSpots, color_spots, color_template, learn_infrared
from followspot_balls.templates.glowing_spot import glowing
from followspot_calibrate.targets.separability import (
    HUE_SHARE,
    LARGEST,
    SIMILARITY,
    SMALLEST,
    accepted_share,
    separability,
)
from followspot_sim.parameters import SimParams
from followspot_sim.rendering.picture import Picture

ROOT = Path(__file__).parents[3]
SIMULATED = load(ROOT / "graphs/rooms/simulated6.yaml")
FRAMES = 24
SHIRTS = {"red": (40, 40, 190), "blue": (190, 80, 50), "green": (60, 160, 60), "white": (150, 150, 150)}


@cache
def film(
    camera: str, target: str, *, people: int = 0, color: tuple[int, int, int] | None = None
) -> list[Array]:
    """A simulated clip of one target, alone or in the hands of people."""
    ball = Target(target, 0.0762)
    alone = "" if people else target
    colors = {} if color is None else {target: color}
    params = SimParams(
        frames=2000, seed=3, people=people, projections=0, hide_balls=False, only_target=alone, colors=colors
    )
    room = replace(SIMULATED, targets={target: ball})
    picture = Picture(params, room, room.cameras[camera])
    pictures = np.empty((FRAMES, *picture.shape), np.uint8)
    for number, out in enumerate(pictures):
        picture.render(number * (20 if people else 1), out)
    return list(pictures)


def lit(frames: list[Array], shirt: tuple[int, ...]) -> list[Array]:
    """The same with a lit person who walks through: shirt, skin, in front of everything dimmer."""
    random = np.random.default_rng(0)
    height, width, channels = frames[0].shape
    pictures = []
    for number, frame in enumerate(frames):
        x, y = 30 + (number * 37) % (width - 60), int(0.55 * height)
        body = np.zeros((height, width, channels), np.uint8)
        cv2.ellipse(body, (x, y), (14, 34), 0, 0, 360, shirt[:channels], -1)
        cv2.circle(body, (x, y - 42), 9, (90, 120, 170) if channels == 3 else (130,), -1)
        cv2.line(body, (x - 12, y - 20), (x - 30, y + 10), shirt[:channels], 7)
        folds = 1 + 0.1 * random.standard_normal((height, width, 1))
        pictures.append(np.maximum(frame, np.clip(body * folds, 0, 255).astype(np.uint8)))
    return pictures


def histogram_of(frames: list[Array]) -> Array:
    return color_template(color_spots(frames))


@pytest.mark.parametrize("shirt", SHIRTS)
@pytest.mark.parametrize("people", [0, 2])
@pytest.mark.parametrize("target", ["green", "magenta"])
def test_a_lit_person_does_not_change_what_is_learnt(target: str, people: int, shirt: str) -> None:
    alone, area = learn_color(film("cam0", target))
    learnt, seen = learn_color(lit(film("cam0", target, people=people), SHIRTS[shirt]))
    assert bhattacharyya(alone, learnt) > 0.98
    assert area[0] / 3 < seen[0] < seen[1] < 1.5 * area[1]


@pytest.mark.parametrize("gray", [60, 110, 160])
@pytest.mark.parametrize("people", [0, 2])
def test_a_lit_person_does_not_change_an_infrared_template(people: int, gray: int) -> None:
    levels, area = learn_infrared(film("cam1", "red"))
    seen_levels, seen = learn_infrared(lit(film("cam1", "red", people=people), (gray,)))
    assert seen_levels[1] == pytest.approx(levels[1], abs=20)
    assert seen_levels[0] > 0.7 * levels[0]
    assert area[0] / 3 < seen[0] < seen[1] < 1.5 * area[1]


def test_a_person_whose_ball_is_out_of_view_is_no_target() -> None:
    frames = film("cam0", "green")
    dark = [np.zeros_like(frame) for frame in frames]
    half = [
        frame if number % 2 else empty for number, (frame, empty) in enumerate(zip(frames, dark, strict=True))
    ]
    spots = glowing([frame.max(axis=2) for frame in lit(half, SHIRTS["green"])], 0.7)
    assert {spot.frame % 2 for spot in spots} == {1}
    assert len(spots) >= 0.8 * FRAMES / 2


def test_distinct_colours_are_told_apart_and_near_ones_are_not() -> None:
    room, clips = learnt_room({"red": (255, 40, 30), "orange": (255, 75, 25), "green": (40, 255, 60)})
    found = separability("cam0", room.targets, clips)
    assert found is not None
    place = {name: number for number, name in enumerate(found.targets)}
    assert found.similarity[place["red"], place["orange"]] > 0.5
    assert found.accepted[place["red"], place["green"]] == found.accepted[place["green"], place["red"]] == 0
    assert np.diag(found.accepted).min() > 0.9
    assert any(
        "orange and red look alike in cam0" in text or "red and orange" in text for text in found.warnings
    )
    assert not any("green" in text for text in found.warnings)


@pytest.mark.parametrize("template", ["red", "orange", "green"])
def test_what_would_be_accepted_is_what_the_detector_accepts(template: str) -> None:
    """The share of frames in which `balls.color_blobs` finds one target with the template of another."""
    colors = {"red": (255, 40, 30), "orange": (255, 75, 25), "green": (40, 255, 60)}
    room, clips = learnt_room(colors)
    chosen = replace(room, targets={template: room.targets[template]})
    camera = room.cameras["cam0"]
    stage = ColorBlobs(Context.serving(camera, chosen))
    stage.setup()
    for seen, color in colors.items():
        frames = film("cam0", seen, color=color)
        found = np.mean([len(stage.process(Frame(camera="cam0", pixels=f)).area) > 0 for f in frames])
        target = room.targets[template]
        share = accepted_share(clips[seen], target.hue_histogram["cam0"], target.area["cam0"])
        assert share == pytest.approx(found, abs=0.15)


def test_sizes_and_hues_are_those_that_the_detector_takes_by_default() -> None:
    default = ColorBlobs.Params()
    ours = SIMILARITY, HUE_SHARE, SMALLEST, LARGEST
    assert ours == (default.similarity, default.minimum_hue_share, default.minimum_area, default.maximum_area)
    hues = np.eye(16)[3]
    sizes = np.array([0.29, 0.31, 2.98, 3.02]) * 100
    assert accepted_share(ColorSpots(np.tile(hues, (4, 1)), sizes), hues, (100.0, 200.0)) == 0.5


def learnt_room(colors: dict[str, tuple[int, int, int]]) -> tuple[Room, dict[str, object]]:
    """A room with templates of simulated targets in cam0, and the spots that they rest on."""
    clips = {name: color_spots(film("cam0", name, color=color)) for name, color in colors.items()}
    targets = {
        name: Target(name, 0.0762, {"cam0": color_template(spots)}, {"cam0": spots.extremes})
        for name, spots in clips.items()
    }
    return replace(SIMULATED, targets=targets), clips


@pytest.fixture
def studio(tmp_path: Path) -> Path:
    """A room with one camera, and clips of two targets of nearly one colour and of a third."""
    camera = Camera(
        "cam0", "color", (160, 120), np.array([[150.0, 0, 80], [0, 150, 60], [0, 0, 1]]), np.zeros(5),
        np.eye(3), np.array([0.0, 0.0, 3.0]),
    )  # fmt: skip
    old = Target("old", 0.05, {"cam0": np.eye(16)[0]}, {"cam0": (60.0, 100.0)})
    save(Room("studio", {"cam0": camera}, {}, {"old": old}), tmp_path / "room.yaml")
    for target, color in {"red": (0, 0, 255), "rose": (10, 0, 255), "green": (0, 255, 0)}.items():
        folder = tmp_path / "clips" / target / "cam0"
        folder.mkdir(parents=True)
        for number in range(10):
            picture = np.zeros((120, 160, 3), np.uint8)
            cv2.circle(picture, (20 + 10 * number, 60), 5, color, -1)
            cv2.imwrite(str(folder / f"{number}.png"), picture)
    return tmp_path


def test_targets_that_look_alike_are_warned_about(studio: Path, capsys: pytest.CaptureFixture[str]) -> None:
    room, clips = str(studio / "room.yaml"), str(studio / "clips")
    assert main(["calibrate", "targets", "--room", room, "--clips", clips, "--json"]) == 0
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert found["separability"]["cam0"]["targets"] == ["old", "green", "red", "rose"]
    assert "red and old look alike in cam0" in said.err or "old and red look alike in cam0" in said.err
    assert "green" not in said.err
    assert found["warnings"] == [line.removeprefix("warning: ") for line in said.err.splitlines()]
    assert main(["calibrate", "targets", "--room", room, "--clips", clips]) == 0
    assert "in the worst camera" in capsys.readouterr().out
    page = (studio / "room.targets.html").read_text()
    assert "look alike in cam0" in page
    assert 'class="verdict look"' in page
    assert page.count("<rect") == 16 * 3  # a bar for each hue of green, red and rose, seen by one camera


def test_targets_that_are_told_apart_are_good(studio: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.rmtree(studio / "clips" / "rose")
    room = load(studio / "room.yaml")
    save(replace(room, targets={}), studio / "room.yaml")
    words = ["--room", str(studio / "room.yaml"), "--clips", str(studio / "clips")]
    assert main(["calibrate", "targets", *words]) == 0
    assert capsys.readouterr().err == ""
    page = (studio / "room.targets.html").read_text()
    assert 'class="verdict good"' in page
    assert "2 targets learnt, told apart by colour" in page
