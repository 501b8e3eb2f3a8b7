"""A room's video is played as by a live camera, and a run beside others tells what came of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from bench.persons import busy_machine
from followspot.room import StageUse
from followspot.room_file import load, save

ROOM = Path(__file__).parents[3] / "graphs/rooms/simulated_panorama.yaml"


def test_the_camera_plays_its_video_at_its_own_pace(tmp_path: Path) -> None:
    room = load(ROOM)
    (name,) = room.cameras
    video = StageUse("cameras.video", {"path": "films/one.mp4"})
    (tmp_path / "room").mkdir()
    file = tmp_path / "room" / "room.yaml"
    save(replace(room, cameras={name: replace(room.cameras[name], source=video)}), file)
    source = load(busy_machine.played(str(file), tmp_path)).cameras[name].source
    assert source is not None
    assert source.uses == "cameras.playback"
    path = Path(source.folder) / str(source.params["path"])
    assert path.resolve() == tmp_path / "room/films/one.mp4"


def test_a_room_without_a_video_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="plays no video: give a room with"):
        busy_machine.played(str(ROOM), tmp_path)


@pytest.mark.thorough
def test_a_run_tells_coverage_and_what_was_searched(tmp_path: Path) -> None:
    told = busy_machine.run(ROOM, 1, 6, tmp_path)
    assert 0 <= told["coverage, %"] <= 100
    assert told["searched"] + told["dropped"] == 6
