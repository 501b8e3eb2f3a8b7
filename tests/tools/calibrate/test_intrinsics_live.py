"""`calibrate intrinsics` with live cameras: their sources, what a terminal shows, how they end."""

import io
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.tools.calibrate.drawn_boards import Photographer, lens, places
from tests.tools.calibrate.intrinsics_command import BOARD, SIZE, intrinsics

from followspot import at
from followspot.errors import InputError
from followspot.messages import Array
from followspot.plugins.catalogue import catalogue
from followspot.ports.marks import Source
from followspot.room import Camera, Room, StageUse
from followspot.room_file import load, save
from followspot.stage import Stage
from followspot.stage_params import Field, StageParams
from followspot.tracking import Frame
from followspot_calibrate.boards.detection import Detector
from followspot_calibrate.boards.pictures import live_pictures
from followspot_calibrate.intrinsics.collecting import collect


class Films(Stage):
    """A live camera that shows a board."""

    live = True
    per_camera = True
    shown: list[Array] = []  # noqa: RUF012  # set by the test

    class Params(StageParams):
        device: int = Field(0, description="any", unit="1")

    def process(self) -> Source[Frame]:
        for number, picture in enumerate(self.shown):
            yield at(number, Frame(camera=self.camera.name, pixels=picture[:, :, None]))


def test_live_camera_is_its_source_and_still_views_count_once(monkeypatch: pytest.MonkeyPatch) -> None:
    photographer = Photographer(lens(), BOARD)
    Films.shown = [photographer.picture(place) for place in places(0.45, (0.3, 0.2), 3) for _ in range(4)]
    monkeypatch.setattr("followspot_calibrate.boards.pictures.load_stage", lambda name: Films)
    camera = lens(source=StageUse("cameras.device", {}))
    collected = collect("cam0", live_pictures(camera), None, Detector(BOARD), io.StringIO())
    assert (collected.looked_at, len(collected.views)) == (12, 3)


def test_device_becomes_the_source_of_a_new_camera(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    photographer = Photographer(lens(), BOARD)
    Films.shown = [photographer.picture(place) for place in places(0.42, (0.35, 0.25), 6)]
    monkeypatch.setattr("followspot_calibrate.boards.pictures.load_stage", lambda name: Films)
    assert intrinsics(tmp_path, "--device", "cam0=2", "--size", "640x480") == 0
    camera = load(tmp_path / "room.yaml").cameras["cam0"]
    assert camera.source is not None
    assert (camera.source.uses, camera.source.params) == ("cameras.device", {"device": 2})
    assert camera.matrix[0, 0] == pytest.approx(520, rel=0.01)


def test_live_needs_a_live_source() -> None:
    assert catalogue()["cameras.video"]
    for source in (None, StageUse("cameras.video", {})):
        with pytest.raises(InputError, match=r"camera cam0 has no live source\n.*cameras.device"):
            next(live_pictures(lens(source=source)))


def test_ctrl_c_ends_a_live_camera_with_what_was_seen() -> None:
    picture = Photographer(lens(), BOARD).picture(places(0.45, (0.3, 0.2), 1)[0])

    def interrupted() -> Iterator[tuple[int, Array]]:
        yield 0, picture
        raise KeyboardInterrupt

    assert len(collect("cam0", interrupted(), None, Detector(BOARD), io.StringIO()).views) == 1


def playing(folder: Path) -> Camera:
    """A camera whose live source shows a board at eight places."""
    photographer = Photographer(lens(), BOARD)
    film = cv2.VideoWriter(str(folder / "board.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30, SIZE)
    for place in places(0.42, (0.35, 0.25), 8):
        film.write(cv2.cvtColor(photographer.picture(place), cv2.COLOR_GRAY2BGR))
    film.release()
    return lens(source=StageUse("cameras.playback", {"path": "board.avi", "speed": 1000}))


def test_a_camera_of_the_room_is_calibrated_live(tmp_path: Path) -> None:
    """A recording that plays as a live camera does, from the room file to the lens in it."""
    camera = replace(playing(tmp_path), matrix=np.eye(3))
    save(Room("studio", {camera.name: camera}), tmp_path / "room.yaml")
    assert intrinsics(tmp_path, "--live") == 0
    found = load(tmp_path / "room.yaml").cameras[camera.name]
    assert found.matrix[0, 0] == pytest.approx(lens().matrix[0, 0], rel=0.02)
    assert found.source is not None
    assert found.source.uses == "cameras.playback"


def test_a_missing_device_is_told_at_once_and_the_others_are_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    camera = playing(tmp_path)
    save(Room("studio", {camera.name: camera}), tmp_path / "room.yaml")
    assert intrinsics(tmp_path, "--live", "--device", "absent=77") == 1
    told = capsys.readouterr()
    assert "absent: its camera gives no pictures: is it connected, and free?" in told.err
    assert camera.name in told.out
    assert list(load(tmp_path / "room.yaml").cameras) == [camera.name]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_terminal_shows_the_coverage_and_is_left_clean() -> None:
    pictures = enumerate(map(Photographer(lens(), BOARD).picture, places(0.45, (0.3, 0.2), 2)))
    terminal = Terminal()
    collect("cam0", iter(pictures), 2, Detector(BOARD), terminal)
    text = terminal.getvalue()
    assert "cam0: 2 views in 2 of 2 pictures" in text
    assert "still missing: " in text
    assert text.endswith("\x1b[2K"), "the last line is wiped"
    drawn, wiped = text.count("\n"), text.count("\x1b[1A")
    assert drawn == wiped > 0, "every line is drawn over or wiped"

    collect("cam0", iter([]), 0, Detector(BOARD), nothing := Terminal())
    assert not re.sub(r"\x1b\[[?\d;]*[A-Za-z]", "", nothing.getvalue()).strip()


def test_pictures_of_two_sizes_are_refused() -> None:
    pictures = [(0, np.zeros((480, 640), "u1")), (1, np.zeros((240, 320), "u1"))]
    with pytest.raises(InputError, match="picture 1 is 320x240 px, those before it 640x480"):
        collect("cam0", iter(pictures), 2, Detector(BOARD), io.StringIO())
