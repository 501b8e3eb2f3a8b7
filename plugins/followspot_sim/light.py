"""The interfering projections: moving spots in the balls' colours, stripes, flashes, shadows of people.

Colours here are linear light, 0 to 255, in the order BGR.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from followspot import Array
from followspot_sim.body import PARTS
from followspot_sim.screen import TEXEL, Screen, atlas_size, screens_of
from followspot_sim.sight import approach
from followspot_sim.world import Scene, Setting, world_of

LAG = 0.25
"""By how much a trailing spot is behind its ball, s."""
SOLID = np.isin(PARTS, ("leg", "torso", "head"))
"""Which parts of a body stop light (the others are too thin to matter)."""
SLOT, FLASH = 1.5, 0.08
"""A flash comes once in each slot and lasts that long, s."""
SUBPIXEL = 4
"""Binary digits after the point in coordinates that are handed to OpenCV."""


@dataclass(frozen=True, eq=False)
class Splashes:
    """Spots that fall on bodies: xyz (S, 3) m, radius (S,) m, color (S, 3), limb (S,) number in the scene."""

    xyz: Array
    radius: Array
    color: Array
    limb: Array


NO_SPLASHES = Splashes(np.empty((0, 3)), np.empty(0), np.empty((0, 3)), np.empty(0, int))


@dataclass(frozen=True)
class Lighting:
    """What decides the projections; equal lightings give equal projections in every process.

    spots: for each ball; brightness: over that of the balls; planes: of the room, in its order;
    colors: of the balls, linear BGR.
    """

    setting: Setting
    spots: int
    brightness: float
    planes: tuple[tuple[float, ...], ...]
    colors: tuple[tuple[float, ...], ...]


@lru_cache(maxsize=4)
def show_of(lighting: Lighting) -> LightShow:
    """The light show of a lighting, shared by the cameras of one process."""
    return LightShow(lighting)


class LightShow:
    """What the projectors throw, frame by frame; the last frames are kept for the next camera."""

    def __init__(self, lighting: Lighting) -> None:
        self.world = world_of(lighting.setting)
        self.screens = screens_of(lighting.planes)
        colors = np.array(lighting.colors).reshape(-1, 3)
        self.active = bool(lighting.spots and self.screens and len(colors))
        self.atlas = lru_cache(maxsize=16)(self._draw)
        self.splashes = lru_cache(maxsize=16)(self._splash)
        rng = np.random.default_rng([lighting.setting.seed, 77])
        self._colors = colors * lighting.brightness
        self._target = np.tile(np.arange(len(colors)), lighting.spots)
        spots = len(self._target)
        self._trailing = np.arange(spots) < len(colors)
        self._screen = np.where(self._trailing, 0, np.arange(spots) // max(len(colors), 1) % max(len(self.screens), 1))
        self._radius = np.where(self._trailing, 0.085, rng.uniform(0.06, 0.15, spots))
        self._rate = rng.uniform(0.15, 0.55, (2, spots, 2)) * rng.choice([-1, 1], (2, spots, 2))
        self._phase = rng.uniform(0, 2 * np.pi, (2, spots, 2))
        self._flash = [lighting.setting.seed, 78]
        self._scenery = _scenery(atlas_size(self.screens), self._colors, rng) if self.active else None

    def _spots(self, time: float) -> Array:
        """Where every spot is on its screen, (N, 2) m along its axes."""
        size = np.array([s.size for s in self.screens])[self._screen]
        sway = np.sin(self._rate * time * np.pi + self._phase)
        where = size / 2 * (1 + 0.62 * sway[0] + 0.3 * sway[1])
        floor = self.screens[0]
        below = (self.world.balls(time - LAG) - floor.corner) @ floor.axes.T
        where[self._trailing] = below + 0.22 * np.sin(2.1 * time + np.arange(2) * 1.6)
        return np.asarray(where)

    def _draw(self, frame: int) -> Array:
        """The atlas of a frame, (H, W, 3) uint8."""
        scene = self.world.scene(frame)
        assert self._scenery is not None  # noqa: S101  # nobody asks when there is no light
        rows, _ = atlas_size(self.screens)
        shift = round(40 * (1 + np.sin(0.35 * scene.time)))
        atlas = self._scenery[shift : shift + rows].copy()
        self._draw_stripe(atlas, scene.time)
        where = self._spots(scene.time)
        for k, screen in enumerate(self.screens):
            first, last, columns = screen.window()
            part = atlas[first:last, :columns]
            for spot in np.flatnonzero(self._screen == k):
                centre = where[spot] / TEXEL
                _disc(part, centre, self._radius[spot] / TEXEL, self._colors[self._target[spot]])
            self._draw_flash(part, k, scene.time)
            self._draw_shadows(part, screen, scene)
        return atlas

    def _draw_stripe(self, atlas: Array, time: float) -> None:
        """A bar of light that turns about the middle of the first screen."""
        first, last, columns = self.screens[0].window()
        angle = 0.4 * time
        middle, arm = np.array([columns, last - first]) / 2, np.array([np.cos(angle), np.sin(angle)]) * columns
        color = self._colors[int(time / 4) % len(self._colors)] * 0.12
        a, b = (tuple(int(v) for v in middle + s * arm) for s in (-1, 1))
        cv2.line(atlas[first:last, :columns], a, b, color.tolist(), 9, cv2.LINE_AA)

    def _draw_flash(self, part: Array, screen: int, time: float) -> None:
        slot = int(time / SLOT)
        rng = np.random.default_rng([*self._flash, screen, slot])
        begin, color = rng.uniform(0, SLOT - FLASH), self._colors[rng.integers(len(self._colors))]
        if 0 <= time - slot * SLOT - begin < FLASH:
            _disc(part, rng.uniform(0.2, 0.8, 2) * part.shape[1::-1], rng.uniform(8, 40), color * 0.8)

    def _draw_shadows(self, part: Array, screen: Screen, scene: Scene) -> None:
        solid = SOLID[scene.part]
        ends = scene.limbs[solid]
        shade, scale = screen.shadow(ends.reshape(-1, 3))
        texel = (screen.texel(shade) - [0, screen.row]).reshape(-1, 2, 2)
        thick = 2 * scene.radius[solid] * scale.reshape(-1, 2).mean(axis=1) / TEXEL
        for (a, b), width in zip(texel, thick, strict=True):
            if np.isfinite(width) and max(np.abs(a).max(), np.abs(b).max()) < 2000:
                cv2.line(part, _whole(a), _whole(b), (0, 0, 0), max(1, round(width)), cv2.LINE_8)

    def _splash(self, frame: int) -> Splashes:
        """Spots that meet a body before they meet their screen."""
        scene = self.world.scene(frame)
        solid = np.flatnonzero(SOLID[scene.part])
        if len(solid) == 0:
            return NO_SPLASHES
        where, hits = self._spots(scene.time), []
        for k, screen in enumerate(self.screens):
            spots = np.flatnonzero(self._screen == k)
            aim = screen.point(where[spots]) - screen.projector
            aim /= np.linalg.norm(aim, axis=1, keepdims=True)
            distance, along = approach(screen.projector, aim, scene.limbs[solid])
            reach = np.where(distance < scene.radius[solid], along, np.inf)
            first = reach.argmin(axis=1)
            met = np.isfinite(reach.min(axis=1))
            depth = scene.radius[solid][first] ** 2 - distance[np.arange(len(spots)), first] ** 2
            go = reach.min(axis=1)[met] - np.sqrt(depth[met])
            xyz = screen.projector + aim[met] * go[:, None]
            target = self._target[spots[met]]
            hits.append((xyz, self._radius[spots[met]], self._colors[target] * 0.7, solid[first[met]]))
        xyz, radius, color, limb = (np.concatenate(column) for column in zip(*hits, strict=True))
        return Splashes(xyz, radius, color, limb)


def _disc(image: Array, centre: Array, radius: float, color: Array) -> None:
    """A disc at a place between pixels; places far outside are left out."""
    if np.abs(centre).max() < 4000:
        x, y, r = (int(v) for v in np.round(np.array([*centre, radius]) * (1 << SUBPIXEL)))
        cv2.circle(image, (x, y), r, color.tolist(), -1, cv2.LINE_AA, SUBPIXEL)


def _whole(point: Array) -> tuple[int, int]:
    return round(float(point[0])), round(float(point[1]))


def _scenery(size: tuple[int, int], colors: Array, rng: np.random.Generator) -> Array:
    """Soft clouds of coloured light, taller than the atlas so that they can drift: (rows, columns, 3) uint8."""
    rows, columns = size[0] + 80, size[1]
    coarse = rng.random((7, 5, len(colors))) ** 3
    coarse = coarse @ colors / len(colors) * 0.35
    return np.asarray(cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC).clip(0, 255).astype("u1"))
