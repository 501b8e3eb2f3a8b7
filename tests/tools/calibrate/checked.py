"""Cameras of a made room, one that somebody knocked against, and a room file of them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.rooms import made_room

from followspot import Camera, Room, Target
from followspot.room_file import save

GLOWBALLS = dataset("glowballs-dev")
needs_recordings = needs_data("glowballs-dev")
CAMERAS = made_room(5, 1).cameras


def turned(camera: Camera, degrees: float) -> Camera:
    """The camera after somebody knocked against it."""
    rotation = cv2.Rodrigues(np.array([0, np.radians(degrees), 0]))[0] @ camera.rotation
    return replace(camera, rotation=rotation, translation=-rotation @ camera.center)


def room_file(path: Path, cameras: Sequence[Camera], name: str = "room.yaml") -> str:
    room = Room("studio", {c.name: c for c in cameras}, {}, {"red": Target("red", 0.05)})
    save(room, path / name)
    return str(path / name)
