"""Cameras, and what they see of a board that is carried through their room."""

from dataclasses import replace

import numpy as np
from tests.tools.calibrate.drawn_boards import lens

from followspot.messages import Array
from followspot.room import Camera
from followspot_calibrate.boards.board import parse_board

BOARD = parse_board("charuco:6x5:0.06:DICT_4X4_50")


def standing(name: str, at: tuple[float, float, float], toward: tuple[float, float, float]) -> Camera:
    """A camera upright in the room."""
    z = np.subtract(toward, at) / np.linalg.norm(np.subtract(toward, at))
    x = np.cross(z, [0.0, 0.0, 1.0])
    R = np.array([x / np.linalg.norm(x), np.cross(z, x / np.linalg.norm(x)), z])
    return lens(name=name, rotation=R, translation=-R @ np.array(at))


def unknown(cameras: list[Camera]) -> list[Camera]:
    """The same lenses; only the first camera's pose is known."""
    return [cameras[0], *(replace(c, rotation=np.eye(3), translation=np.zeros(3)) for c in cameras[1:])]


def apart(found: tuple[Camera, ...], true: list[Camera]) -> Array:
    """Distances of the centres, m."""
    pairs = zip(found, true, strict=True)
    return np.array([np.linalg.norm(a.center - b.center) for a, b in pairs])
