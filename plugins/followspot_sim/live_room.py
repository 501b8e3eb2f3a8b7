"""A room in which the recording of a simulated room is played by live cameras."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from followspot import Room, room_file
from followspot.room import StageUse

PLAYBACK = "cameras.playback"


def write_live_room(room: Room, folder: Path) -> None:
    """Write `folder`/room.yaml, which plays the videos there again and again.

    It has no ground truth: a loop has no end, and the times of live frames are those of the recording.
    """
    cameras = {
        name: replace(camera, source=StageUse(PLAYBACK, {"path": f"{name}.mkv", "loop": True}, str(folder)))
        for name, camera in room.cameras.items()
    }
    room_file.save(replace(room, cameras=cameras, truth=None), folder / "room.yaml")
