"""Rooms made from the simulated one by hand: with one camera, and with cameras that play what it recorded."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import yaml
from tests.commands import command

GRAPHS = Path(__file__).parents[2] / "graphs"
ROOMS = GRAPHS / "rooms"
FRAMES = "100"
"""Length of what is recorded."""


def one_camera(folder: Path) -> Path:
    """The first colour camera, alone."""
    room = simulated()
    room["cameras"] = {"cam0": room["cameras"]["cam0"]}
    for target in room["targets"].values():
        for template in target.values():
            if isinstance(template, dict):
                for name in [*template]:
                    if name not in room["cameras"]:
                        del template[name]
    del room["truth"]
    return written(folder, room)


def videos(folder: Path) -> Path:
    """A video for each camera, and the truth as a table."""
    words = ("simulate", "--room", ROOMS / "simulated.yaml", "--out", folder / "videos")
    command(*words, "--frames", FRAMES, check=True)
    room = simulated()
    for name, camera in room["cameras"].items():
        camera["source"] = {"uses": "cameras.video", "with": {"path": f"videos/{name}.mkv"}}
    room["truth"] = {"uses": "cameras.truth_csv", "with": {"path": "videos/truth.csv"}}
    return written(folder, room)


def pictures(folder: Path) -> Path:
    """A folder of pictures for each camera."""
    room = yaml.safe_load(videos(folder).read_text())
    for name, camera in room["cameras"].items():
        (folder / name).mkdir()
        video, number = cv2.VideoCapture(str(folder / "videos" / f"{name}.mkv")), 0
        while True:
            there, picture = video.read()
            if not there:
                break
            cv2.imwrite(str(folder / name / f"{number}.png"), picture)
            number += 1
        camera["source"] = {"uses": "cameras.images", "with": {"path": name, "fps": 60}}
    return written(folder, room)


def recording(folder: Path) -> Path:
    """One recording of the demo, of which each camera plays its port."""
    path = folder / "first.mcap"
    words = ("--frames", FRAMES, "--record", path, "--record-pictures", "raw", "--out", folder / "first")
    command("run", GRAPHS / "glowballs.yaml", *words, check=True)
    room = simulated()
    for name, camera in room["cameras"].items():
        port = {"path": path.name, "port": f"camera/{name}.out"}
        camera["source"] = {"uses": "recording.frame", "with": port}
    return written(folder, room)


MADE: dict[str, Callable[[Path], Path]] = {
    "one camera": one_camera,
    "videos": videos,
    "pictures": pictures,
    "recording": recording,
}
"""By name: writes a room file into a folder."""


def simulated() -> dict[str, Any]:
    """The room of the demo."""
    room = yaml.safe_load((ROOMS / "simulated.yaml").read_text())
    assert isinstance(room, dict)
    return room


def written(folder: Path, room: dict[str, Any]) -> Path:
    """The file with this room."""
    path = folder / "room.yaml"
    path.write_text(yaml.safe_dump(room))
    return path
