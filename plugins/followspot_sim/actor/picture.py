"""The picture of one camera of the actors in their room."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_sim.actor.backdrop import backdrop, lamp_of
from followspot_sim.actor.paint import (
    FARTHEST,
    Patches,
    clipped,
    fill_patches,
    in_picture,
    patches,
    shade,
    unwrapped,
)
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.scene import stage_of
from followspot_sim.rendering.outline import SUBPIXEL, fixed_point
from followspot_sim.sensor import Sensor, own_rng

SHADOW, SHADE = (0.46, 0.38, 0.30, 0.22), 0.9
"""Radii of the discs of shadow below a person, m, and how much light each leaves."""
CIRCLE = np.linspace(0, 2 * np.pi, 16, endpoint=False)
DISC = np.column_stack([np.cos(CIRCLE), np.sin(CIRCLE), 0 * CIRCLE])
SOFT = 0.6
"""Blur of the lens, px."""


class ActorPicture:
    """One camera's pictures of the simulated room, any frame at any time."""

    def __init__(self, params: ActorParams, camera: Camera) -> None:
        """Prepare all that stays: the empty room and the noise."""
        self.camera = camera
        self.shape = (camera.size[1], camera.size[0], 3)
        self._actors = params
        self._stage = stage_of(params)
        self._lamp = lamp_of(params)
        empty = backdrop(params, camera)
        self._empty, self._away = empty.picture, empty.away
        self._sensor = Sensor(self.shape, params.noise_sigma, own_rng(params.seed, camera.name))

    def render(self, frame: int, out: Array) -> None:
        """The picture of a frame into `out`, (H, W, 3) uint8, BGR."""
        light = self._actors.light(frame / self._actors.fps)
        picture = self.light(frame)
        self._sensor.expose(picture if light == 1 else cv2.convertScaleAbs(picture, alpha=light), frame, out)

    def light(self, frame: int) -> Array:
        """The picture in full light, before the sensor exposes it, (H, W, 3) uint8, BGR."""
        play = self._stage.play(frame)
        picture = self._empty.copy()
        level = np.array([np.hypot(*(self.camera.center[:2] - (s.x, s.y))) for s in play.stances])
        for stance in play.stances:
            self._cast_shadow(picture, np.array([stance.x, stance.y, 0.0]))
        for person in np.argsort(-level, kind="stable").tolist():
            self._draw(picture, person, play.surfaces[person], level[person])
        cv2.GaussianBlur(picture, (0, 0), SOFT, dst=picture)
        return picture

    def _draw(self, picture: Array, person: int, surface: Array, level: float) -> None:
        """One person, behind the furniture that is nearer; `level`: how far away, m."""
        actor = self._stage.cast[person]
        seen = patches(self.camera, surface, actor.body.mesh.face)
        quad = surface[actor.body.mesh.face[seen.face]]
        tones = shade(quad, actor.color[seen.face], self._lamp).tolist()
        for placed in in_picture(self.camera, seen):
            fill_patches(picture, placed.polygon, tones)
            window = clipped(placed.window, self.shape)
            nearer = self._away[window] < level
            picture[window][nearer] = self._empty[window][nearer]

    def _cast_shadow(self, picture: Array, place: Array) -> None:
        """Darken the floor below a person."""
        rings = np.concatenate([place + radius * DISC for radius in SHADOW])
        pixel = project(self.camera, rings)
        if self.camera.model == "cylinder":
            pixel[:, 0] = unwrapped(self.camera, pixel[:, 0])
        if not (np.abs(pixel) < FARTHEST).all():
            return
        (x0, y0), (x1, y1) = np.floor(pixel.min(axis=0)), np.ceil(pixel.max(axis=0))
        shade_of = Patches(fixed_point(pixel), np.empty(0, int), (int(x0), int(y0), int(x1), int(y1)))
        for placed in in_picture(self.camera, shade_of):
            self._darken(picture, placed)

    def _darken(self, picture: Array, discs: Patches) -> None:
        rows, columns = window = clipped(discs.window, self.shape)
        light = np.full(picture[window].shape[:2], 255, np.uint8)
        corner = np.array([columns.start << SUBPIXEL, rows.start << SUBPIXEL], np.int32)
        polygons = (discs.polygon - corner).reshape(len(SHADOW), -1, 2)
        for depth, polygon in enumerate(polygons, start=1):
            cv2.fillConvexPoly(light, polygon, round(255 * SHADE**depth), cv2.LINE_8, SUBPIXEL)
        light[np.isfinite(self._away[window])] = 255
        picture[window] = cv2.multiply(
            picture[window], cv2.cvtColor(light, cv2.COLOR_GRAY2BGR), scale=1 / 255
        )
