"""Clips of a ball in front of five cameras that are known exactly: it glows, or a lamp shades it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from tests.tools.calibrate.rooms import made_room

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array

SIZE = (320, 240)
FRAMES = 30
RADIUS = 0.0762
POINTS = np.random.default_rng(0).uniform([-1.2, -1.2, 0.4], [1.2, 1.2, 1.8], (FRAMES, 3))


def small(camera: Camera) -> Camera:
    """The same camera with half of the pixels along each side and without distortion."""
    matrix = np.diag([0.5, 0.5, 1.0]) @ camera.matrix
    return replace(camera, size=SIZE, matrix=matrix, distortion=np.zeros(5))


TRUE = [small(camera) for camera in made_room(5, 1).cameras]


def write_clips(folder: Path, late: int = 0, light: Array | None = None) -> Path:
    """A green ball as the true cameras see it, in pictures.

    late: frames by which cam1 begins later; light: (3,) direction to a lamp that shades the ball, which glows
    without one.
    """
    for camera in TRUE:
        place = folder / "green" / camera.name
        place.mkdir(parents=True)
        shift = late if camera.name == "cam1" else 0
        for number, point in enumerate(np.roll(POINTS, -shift, axis=0)):
            picture = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
            middle = project(camera, point[None])[0]
            radius = RADIUS * camera.matrix[0, 0] / np.linalg.norm(point - camera.center)
            if light is None:
                fine = np.rint(16 * middle).astype(int).tolist()
                cv2.circle(picture, fine, round(16 * radius), (0, 255, 0), -1, cv2.LINE_AA, shift=4)
            else:
                picture[..., 1] = shaded(middle, float(radius), camera.rotation @ light)
            cv2.imwrite(str(place / f"{number:03}.png"), picture)
    return folder


def shaded(middle: Array, radius: float, light: Array) -> Array:
    """A matt ball in the light of a lamp, (H, W) u8.

    light: (3,) direction to the lamp in coordinates of the camera.
    """
    level = np.zeros((SIZE[1], SIZE[0]))
    corner = np.floor(middle - radius).astype(int) - 1
    side = int(2 * radius) + 4
    row, column = (axis / 4 - 0.375 for axis in np.mgrid[: 4 * side, : 4 * side])  # four times finer
    right, down = (column + corner[0] - middle[0]) / radius, (row + corner[1] - middle[1]) / radius
    ahead = 1 - right**2 - down**2
    cosine = np.stack([right, down, -np.sqrt(np.maximum(ahead, 0))], axis=2) @ light
    fine = np.where(ahead > 0, 10 + 200 * np.maximum(cosine, 0), 0)
    window = fine.reshape(side, 4, side, 4).mean(axis=(1, 3))
    level[corner[1] : corner[1] + side, corner[0] : corner[0] + side] = window
    return level.astype(np.uint8)
