"""Names and picture sizes of the cameras in a file of points."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.errors import InputError
from followspot.messages import Array


def names_of(path: Path, count: int, cameras: Sequence[Camera]) -> tuple[str, ...]:
    """Names of cameras: the room's, or cam0, cam1, ... Raises InputError if the room has more or fewer."""
    if not cameras:
        return tuple(f"cam{number}" for number in range(count))
    if count != len(cameras):
        text = f"{path} has {count} cameras, the room {len(cameras)}"
        raise InputError.of(text, "remove the others from the room, or calibrate a new one")
    return tuple(camera.name for camera in cameras)


def sizes_of(
    path: Path, names: Sequence[str], cameras: Sequence[Camera], size: tuple[int, int] | None
) -> Array:
    """Width and height of the cameras' pictures, (C, 2) px. Raises InputError if they are unknown."""
    known = {camera.name: camera.size for camera in cameras}
    sizes = [known.get(name, size) for name in names]
    if None in sizes:
        text = f"{path} does not say how large the pictures are"
        raise InputError.of(text, "give --size 640x480, or --room with these cameras")
    return np.array(sizes).reshape(-1, 2)
