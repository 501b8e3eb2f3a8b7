"""Stage `sim.marker_camera`: one camera of a room with square markers that float, turn and tilt."""

from __future__ import annotations

from typing import ClassVar

import cv2
import numpy as np

from followspot import Array, Camera, Field, Source, StageParams
from followspot.geometry import project
from followspot.tracking import Frame
from followspot_sim.performance import Performance
from followspot_sim.rendering.screen import rays_of
from followspot_sim.sensor import own_rng

MODULES = 8
"""Modules along a side: four of the pattern, a black border and a white margin around them."""
MARGIN = MODULES / 6
"""Side of the white plate over that of the marker."""
FINE = 3
"""Lines of sight along each side of a pixel."""
CELL = 16
"""Texels of a module."""


class MarkerSimParams(StageParams):
    """The markers and their motion; equal parameters give equal rooms."""

    frames: int = Field(300, ge=0, unit="frames", description="length of the recording; 0: endless")
    fps: float = Field(30.0, ge=0.001, le=1000, unit="1/s", description="pictures of each camera per second")
    seed: int = Field(1, ge=0, unit="1", description="seed of the noise")
    markers: int = Field(3, ge=0, le=50, unit="1", description="number of markers, 0, 1, ... of DICT_4X4_50")
    size: float = Field(0.2, gt=0, le=10, unit="m", description="side of a marker without its white margin")
    noise_sigma: float = Field(
        2.0, ge=0, le=50, unit="grey levels", description="standard deviation of the sensor noise"
    )
    realtime: bool = Field(
        False, description="whether frames come at the pace of fps instead of as fast as possible"
    )


def marker_pose(marker: int, markers: int, time: float) -> tuple[Array, Array]:
    """Rotation (3, 3) from a marker's axes to those of the room, and its middle (3,) m, at a time, s.

    The markers go round in a circle of 0.7 m, turn about the vertical, and tilt by up to 35 degrees.
    """
    way = 2 * np.pi * marker / max(markers, 1) + 0.8 * time
    middle = np.array([0.7 * np.cos(way), 0.7 * np.sin(way), 1.0 + 0.2 * np.sin(1.7 * time + marker)])
    turn, tilt = 0.9 * time + marker, 0.6 * np.sin(1.3 * time + 2 * marker)
    about_up = cv2.Rodrigues(np.array([0.0, 0.0, turn]))[0]
    about_side = cv2.Rodrigues(np.array([tilt, 0.0, 0.0]))[0]
    return about_up @ about_side, middle


class MarkerCamera(Performance):
    """Render square markers as this camera sees them: every pixel along its own lines of sight."""

    per_camera: ClassVar[bool] = True

    class Params(MarkerSimParams):
        """The markers."""

    params: Params

    def setup(self) -> None:
        """Draw the markers and the empty room."""
        self._plates = [_plate(number) for number in range(self.params.markers)]
        self._rays = _fine_rays(self.camera)
        self._rng = own_rng(self.params.seed, self.camera.name)
        width, height = self.camera.size
        down, right = np.mgrid[:height, :width] / max(width, height)
        self._empty = 70 + 50 * down + 20 * np.sin(9 * right)

    def process(self) -> Source[Frame]:
        """Pictures, frame k at k / fps seconds."""
        for frame in self.frames():
            light = self.picture(frame / self.params.fps)
            light += self._rng.normal(0, self.params.noise_sigma, light.shape)
            gray = light.clip(0, 255).round().astype(np.uint8)[..., None]
            pixels = gray if self.camera.kind == "infrared" else np.repeat(gray, 3, axis=2)
            yield self.at(frame, Frame(self.camera.name, pixels))

    def picture(self, time: float) -> Array:
        """The picture at a time (s) without noise, (H, W) grey levels; near markers hide far ones."""
        light = self._empty.copy()
        poses = [marker_pose(k, self.params.markers, time) for k in range(self.params.markers)]
        for k in sorted(range(len(poses)), key=lambda k: -np.linalg.norm(poses[k][1] - self.camera.center)):
            self._draw(light, self._plates[k], *poses[k])
        return np.asarray(light)

    def _draw(self, light: Array, plate: Array, rotation: Array, middle: Array) -> None:
        """Draw one plate, whose face alone is printed."""
        half = self.params.size * MARGIN / 2
        if (self.camera.center - middle) @ rotation[:, 2] <= 0:
            return
        corners = middle + half * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) @ rotation.T
        pixel = project(self.camera, corners)
        if not np.isfinite(pixel).all():
            return
        width, height = self.camera.size
        left, top = np.clip(pixel.min(axis=0) - 2, 0, [width, height]).astype(int)
        right, below = np.clip(pixel.max(axis=0) + 3, 0, [width, height]).astype(int)
        if left >= right or top >= below:
            return
        rays = self._rays[FINE * top : FINE * below, FINE * left : FINE * right]
        local = rays @ rotation
        reach = ((middle - self.camera.center) @ rotation[:, 2]) / np.minimum(local[..., 2], -1e-9)
        on_plate = (self.camera.center - middle) @ rotation[:, :2] + reach[..., None] * local[..., :2]
        texel = ((on_plate * [1, -1] / half + 1) / 2 * len(plate)).astype(np.float32) - np.float32(0.5)
        shown = cv2.remap(plate, texel[..., 0], texel[..., 1], cv2.INTER_LINEAR, borderValue=-1.0)
        behind = np.repeat(np.repeat(light[top:below, left:right], FINE, axis=0), FINE, axis=1)
        mixed = np.where(np.abs(on_plate).max(axis=2) <= half, np.maximum(shown, 0), behind)
        light[top:below, left:right] = mixed.reshape(below - top, FINE, right - left, FINE).mean(axis=(1, 3))


def _plate(number: int) -> Array:
    """A marker with its white margin, float32 grey levels."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    marker = cv2.aruco.generateImageMarker(dictionary, number, 6 * CELL)
    plate = np.full((MODULES * CELL, MODULES * CELL), 255, np.uint8)
    plate[CELL:-CELL, CELL:-CELL] = marker
    return np.float32(40) + plate.astype(np.float32) * np.float32(190 / 255)


def _fine_rays(camera: Camera) -> Array:
    """Directions of FINE x FINE lines of sight in each pixel, (FINE H, FINE W, 3)."""
    width, height = camera.size
    rays = rays_of(camera).astype(np.float32)
    return np.asarray(cv2.resize(rays, (FINE * width, FINE * height), interpolation=cv2.INTER_LINEAR))
