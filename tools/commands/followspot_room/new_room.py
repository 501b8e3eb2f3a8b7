"""`followspot room new`: a room for videos or a webcam without a calibration, for what pictures show."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from followspot import Camera, Room
from followspot.errors import InputError, require_unused, writing
from followspot.room import StageUse
from followspot.room_file import save
from followspot_room.moving import moved
from followspot_room.recorded_size import picture_size

HEIGHT = 1.5
"""Height of the cameras above the floor, m: a tripod's."""


def new_room(
    videos: Sequence[Path],
    device: str | None,
    size: tuple[int, int],
    output: Path,
    field: float,
    *,
    as_json: bool,
) -> int:
    """Write the room file and say what to do next; returns the exit code. Raises InputError.

    device: of a webcam, None for none, with pictures of this size, px; field: horizontal field of view, rad.
    """
    require_unused(output)
    room = room_of(videos, device, size, output, field)
    with writing(output):
        output.parent.mkdir(parents=True, exist_ok=True)
        save(room, output)
    print(_as_json(room) if as_json else _summary(room, output, field))
    return 0


def room_of(
    videos: Sequence[Path], device: str | None, size: tuple[int, int], output: Path, field: float
) -> Room:
    """A room of level cameras beside each other at its origin, named cam0, cam1, ... Raises InputError."""
    sources = [(_source(video), _size(video)) for video in videos]
    if device is not None:
        number = int(device) if device.isdecimal() else device
        sources.append((StageUse("cameras.device", {"device": number}), size))
    if not sources:
        raise InputError.of("there is neither a video nor a webcam", "add --video FILE or --webcam 0")
    cameras = {f"cam{n}": camera_of(f"cam{n}", *found, field) for n, found in enumerate(sources)}
    return moved(Room(name=output.stem, cameras=cameras), output)


def camera_of(name: str, source: StageUse, size: tuple[int, int], field: float) -> Camera:
    """A colour camera without distortion that looks along x; field: horizontal field of view, rad."""
    width, height = size
    focal = width / 2 / np.tan(field / 2)
    rotation = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    return Camera(
        name=name,
        kind="color",
        size=size,
        matrix=np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]]),
        distortion=np.zeros(5),
        rotation=rotation,
        translation=-rotation @ np.array([0.0, 0.0, HEIGHT]),
        source=source,
    )


def _source(video: Path) -> StageUse:
    return StageUse("cameras.images" if video.is_dir() else "cameras.video", {"path": str(video)})


def _size(video: Path) -> tuple[int, int]:
    """Size of the pictures of a video or of a folder of pictures. Raises InputError."""
    if not video.exists():
        remedy = (
            f"a webcam is --webcam {video}"
            if video.name.isdigit()
            else "give a video, or a folder of pictures"
        )
        raise InputError.of(f"there is no video {video}", remedy)
    found = picture_size(video)
    if found is None:
        raise InputError.of(f"there is no picture in {video}", "give a video, or a folder of pictures")
    return found


def _summary(room: Room, output: Path, field: float) -> str:
    lines = [f"{output}:"]
    for camera in room.cameras.values():
        width, height = camera.size
        lines.append(
            f"  {camera.name}: {width} x {height} px, {np.degrees(field):.0f} degrees wide (a guess)"
        )
    lines += [
        "good for what is seen in the pictures; places in space need a calibration (docs/calibration.md)",
        f"next, learn a ball: followspot calibrate targets --room {output} --pick red",
    ]
    return "\n".join(lines)


def _as_json(room: Room) -> str:
    cameras = {name: {"size": list(camera.size)} for name, camera in room.cameras.items()}
    return json.dumps({"room": room.name, "cameras": cameras})
