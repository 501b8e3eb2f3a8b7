"""Standard output of a calibration has its result alone, whatever the stages print that it runs."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from tests.tools.own_ball import middle, room_for

from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot.ports.marks import Source
from followspot.room_file import load
from followspot.stage import Stage
from followspot.stage_params import Field, StageParams
from followspot.tracking import Frame
from followspot_calibrate import tracked
from followspot_calibrate.board import command as board_command
from followspot_calibrate.boards import pictures
from followspot_calibrate.targets import command as targets_command
from followspot_calibrate.targets import pick_command
from followspot_cameras.video.stage import Video

GRAPHS = Path(__file__).parents[3] / "graphs"
ROOM = GRAPHS / "rooms" / "simulated.yaml"
BOARD = "charuco:7x5:0.04:DICT_4X4_50"
PRINTED = {"a stage", "its library"}


def talk() -> None:
    print("a stage")
    os.write(1, b"its library\n")


def run(*_: object) -> None:
    talk()
    raise FollowspotError("ended")


class Talking(Video):
    """A recording whose stage prints."""

    def process(self) -> Source[Frame]:
        talk()
        yield from super().process()


class Silent(Stage):
    """A live camera that prints and gives no picture."""

    live = True
    per_camera = True

    class Params(StageParams):
        device: int = Field(0, description="any", unit="1")

    def process(self) -> Source[Frame]:
        talk()
        return
        yield


@pytest.mark.parametrize("command", ["clocks", "refine"])
def test_what_stages_print_goes_to_standard_error(
    command: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tracked, "run_plan", run)
    words = ["--room", str(ROOM), "--graph", str(GRAPHS / "glowballs.yaml"), "--frames", "2", "--json"]
    assert main(["calibrate", command, *words]) == 1
    said = capfd.readouterr()
    assert said.out == ""
    assert set(said.err.splitlines()) >= PRINTED


@pytest.mark.parametrize("command", ["board", "targets"])
def test_so_it_does_while_recordings_are_read(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(board_command, "find_views", run)
    monkeypatch.setattr(targets_command, "learn_with_progress", run)
    (tmp_path / "red").mkdir()
    clips = [f"--clip={name}={tmp_path}" for name in load(ROOM).cameras]
    words = ["--board", BOARD, *clips] if command == "board" else ["--clips", str(tmp_path)]
    assert main(["calibrate", command, "--room", str(ROOM), *words, "--json"]) == 1
    said = capfd.readouterr()
    assert said.out == ""
    assert set(said.err.splitlines()) >= PRINTED


def test_a_picked_target_is_the_one_json_object(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    room = room_for(tmp_path)
    monkeypatch.setattr(pick_command, "load_stage", lambda _: Talking)
    capfd.readouterr()
    place = "red={},{}".format(*middle(6))
    assert main(["calibrate", "targets", "--room", room, "--pick", place, "--json"]) == 0
    said = capfd.readouterr()
    assert set(json.loads(said.out)["targets"]) == {"red"}
    assert set(said.err.splitlines()) >= PRINTED
    assert main(["calibrate", "targets", "--room", room, "--pick", "red"]) == 0
    said = capfd.readouterr()
    assert said.out.startswith("look at ")
    assert set(said.err.splitlines()) >= PRINTED


def test_lenses_of_live_cameras_are_the_one_json_object(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(pictures, "load_stage", lambda _: Silent)
    words = ["--room", str(tmp_path / "room.yaml"), "--board", BOARD, "--device", "cam0=2", "--json"]
    assert main(["calibrate", "intrinsics", *words]) == 1
    said = capfd.readouterr()
    json.loads(said.out)
    assert set(said.err.splitlines()) >= PRINTED
