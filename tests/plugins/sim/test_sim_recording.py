"""`followspot simulate`: videos that lose nothing, and the truth beside them."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from followspot import FollowspotError, InputError, Room, room_file
from followspot.cli.main import main
from followspot.graph.compile import compile_graph
from followspot.room import StageUse
from followspot_sim.recording import clock_offset_of, parameters_of
from followspot_sim.rendering.picture import Picture
from followspot_sim.video import new_video

ROOM_FILE = Path(__file__).parents[3] / "graphs/rooms/simulated.yaml"
ROOM = room_file.load(ROOM_FILE)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    arguments = ["simulate", "--room", str(ROOM_FILE), "--out", str(folder), "--frames", "4", "--seed", "3"]
    assert main([*arguments, "--live"]) == 0
    return folder


def test_the_recording_is_a_room_of_live_cameras_too(recording: Path) -> None:
    room = room_file.load(recording / "room.yaml")
    assert {name: camera.source.params["path"] for name, camera in room.cameras.items() if camera.source} == {
        name: f"{name}.mkv" for name in ROOM.cameras
    }
    assert room.truth is None
    plan = compile_graph(ROOM_FILE.parents[1] / "glowballs.yaml", room=recording / "room.yaml")
    assert plan.live
    assert [s.params["loop"] for s in plan.stages if s.name.startswith("camera/")] == [True] * len(
        room.cameras
    )


@pytest.mark.parametrize("name", ["cam0", "cam1"])
def test_a_video_gives_back_every_pixel(recording, name):
    params = parameters_of(ROOM, frames=4, seed=3)
    picture = Picture(params, ROOM, ROOM.cameras[name])
    video, pixels = cv2.VideoCapture(str(recording / f"{name}.mkv")), np.empty(picture.shape, np.uint8)
    for frame in range(4):
        there, read = video.read()
        picture.render(frame, pixels)
        assert there
        assert np.array_equal(read, np.broadcast_to(pixels, read.shape))
    assert not video.read()[0]


def test_the_folder_may_have_any_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "--room", str(ROOM_FILE), "--out", "12:30 %d", "--frames", "1"]) == 0
    assert len(list((tmp_path / "12:30 %d").glob("*.mkv"))) == len(ROOM.cameras)


def test_the_truth_has_a_row_for_each_frame_and_target(recording):
    with (recording / "truth.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["frame"], row["object"]) for row in rows] == [
        (str(frame), name) for frame in range(4) for name in ROOM.targets
    ]
    assert rows[3]["time"] == "0.016667"
    assert rows[0]["trackable"] == "1"
    assert all(0 <= float(row["c5_vis"]) <= 1 for row in rows)


def test_template_clips_show_one_target_each(tmp_path):
    out = str(tmp_path / "clips")
    assert main(["simulate", "--room", str(ROOM_FILE), "--out", out, "--templates", "--frames", "2"]) == 0
    clips = sorted(str(path.relative_to(out)) for path in Path(out).rglob("*.mkv"))
    assert clips == sorted(f"{target}/{camera}.mkv" for target in ROOM.targets for camera in ROOM.cameras)
    _, picture = cv2.VideoCapture(f"{out}/red/cam0.mkv").read()
    bright = picture[picture.max(axis=2) > 200]
    bright = bright[bright.max(axis=1) - bright.min(axis=1) > 100]  # without hot pixels
    assert len(bright) > 5
    assert (bright.argmax(axis=1) == 2).all()


def test_a_room_with_real_cameras_is_refused():
    camera = replace(ROOM.cameras["cam0"], source=StageUse("cameras.video", {"path": "cam0.mkv"}))
    with pytest.raises(InputError, match=r"sim\.camera"):
        parameters_of(Room(cameras={"cam0": camera}))


def test_a_seed_out_of_range_is_refused_by_name():
    with pytest.raises(InputError, match="seed"):
        parameters_of(ROOM, seed=-1)


def test_an_endless_room_needs_a_number_of_frames():
    with pytest.raises(InputError, match="--frames"):
        parameters_of(ROOM, frames=0)


def test_cameras_of_a_room_may_differ_in_their_clocks_alone():
    def room(**own):
        source = replace(ROOM.cameras["cam1"].source, params={**ROOM.cameras["cam1"].source.params, **own})
        return replace(ROOM, cameras={**ROOM.cameras, "cam1": replace(ROOM.cameras["cam1"], source=source)})

    assert parameters_of(room(clock_offset=0.01)) == parameters_of(ROOM)
    assert clock_offset_of(room(clock_offset=0.01).cameras["cam1"]) == 0.01
    with pytest.raises(InputError, match="clock_offset"):
        parameters_of(room(clock_offset="late"))
    with pytest.raises(InputError, match="same parameters"):
        parameters_of(room(noise_sigma=3))


def test_a_video_whose_folder_was_removed_meanwhile_is_not_called_a_full_disk(tmp_path: Path) -> None:
    removed = r"a\.mkv was moved or removed while it was written\n    simulate again, and leave the folder"
    with pytest.raises(FollowspotError, match=removed), new_video(tmp_path / "a.mkv", 30.0, (64, 48), 3):
        (tmp_path / "a.mkv").unlink()
