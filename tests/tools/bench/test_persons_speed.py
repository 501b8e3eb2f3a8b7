"""The benchmark of the fast instance runs, and tells how many people it followed."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from bench.persons import speed
from benching import person_stages
from followspot.room import StageUse
from followspot.room_file import load

ROOM = Path(__file__).parents[3] / "graphs/rooms/simulated_panorama.yaml"


def test_recordings_are_found_from_the_folder_of_the_room_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    folder = tmp_path / "rooms"
    folder.mkdir()
    video = cv2.VideoWriter(str(folder / "c.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for _ in range(3):
        video.write(np.full((48, 64, 3), 90, np.uint8))
    video.release()
    monkeypatch.chdir(tmp_path)
    use = StageUse("cameras.video", {"path": "c.avi"}, str(folder))
    room = load(ROOM)
    camera = replace(next(iter(room.cameras.values())), size=(64, 48), source=use)
    source = person_stages.build_used_stage(use, replace(room, cameras={camera.name: camera}))
    assert next(iter(source.process())).pixels.shape == (48, 64, 3)
    source.close()


@pytest.mark.thorough
def test_frames_a_second_are_told_with_particles_and_people(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    size = "--frames 6 --every 2 --particles 40 --json"
    monkeypatch.setattr(sys, "argv", ["speed.py", "--room", str(ROOM), *size.split()])
    speed.main()
    figures = json.loads(capsys.readouterr().out)
    assert figures["size"] == [1396, 260]
    assert figures["frames"] == 6
    assert figures["particles"] == 40
    assert figures["persons"] > 0
    assert figures["frames_per_s"] == pytest.approx(
        1000 / (figures["gradients_ms"] + figures["pose_tracker_ms"])
    )
