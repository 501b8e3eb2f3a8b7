"""A room with two balls, and pictures of discs in it."""

from __future__ import annotations

import numpy as np
from tests.plugins.balls.scene import SIZE, disc, make_room

from followspot.message_checks.sealing import seal
from followspot.messages import Array
from followspot.tracking import Frame

ROOM = make_room()


def painted(camera: str, discs: list[tuple[float, float, float, tuple[int, int, int]]]) -> Frame:
    """A picture of discs: x, y, radius, colour."""
    pixels = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    for x, y, radius, color in discs:
        disc(pixels, np.array([x, y]), radius, color)
    color_camera = ROOM.cameras[camera].kind == "color"
    return seal(Frame(camera=camera, pixels=pixels if color_camera else pixels[..., :1].copy()))


def discs(*centers: tuple[float, float]) -> Array:
    """Bright discs of radius 8 px with blurred edges, (60, 60) u8. centers: x and y, px."""
    y, x = np.mgrid[:60, :60]
    edge = [1 / (1 + np.exp((np.hypot(x - a, y - b) - 8) / 0.5)) for a, b in centers]
    return np.asarray(200 * np.max(edge, axis=0)).astype(np.uint8)
