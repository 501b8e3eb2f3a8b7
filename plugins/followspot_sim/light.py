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
        self._spots = lru_cache(maxsize=4)(self._place_spots)
        rng = np.random.default_rng([lighting.setting.seed, 77])
        self._colors = colors * lighting.brightness
        self._target = np.tile(np.arange(len(colors)), lighting.spots)
        spots = len(self._target)
        self._trailing = np.arange(spots) < len(colors)
        self._screen = np.where(
            self._trailing, 0, np.arange(spots) // max(len(colors), 1) % max(len(self.screens), 1)
        )
        self._radius = np.where(self._trailing, 0.085, rng.uniform(0.06, 0.15, spots))
        self._rate = rng.uniform(0.15, 0.55, (2, spots, 2)) * rng.choice([-1, 1], (2, spots, 2))
        self._phase = rng.uniform(0, 2 * np.pi, (2, spots, 2))
        self._seed = lighting.setting.seed
        self._flash = lru_cache(maxsize=8)(self._plan_flash)
        self._scenery = _scenery(atlas_size(self.screens), self._colors, rng) if self.active else None

    def _place_spots(self, time: float) -> Array:
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
        assert self._scenery is not None  # nobody asks when there is no light
        rows, _ = atlas_size(self.screens)
        shift = round(40 * (1 + np.sin(0.35 * scene.time)))
        atlas = self._scenery[shift : shift + rows].copy()
        self._draw_stripe(atlas, scene.time)
        where = self._spots(scene.time)
        for k, screen in enumerate(self.screens):
            first, last, columns = screen.window()
            part = atlas[first:last, :columns]
            for spot in np.flatnonzero(self._screen == k):
                color = self._colors[self._target[spot]]
                _disc(part, where[spot] / TEXEL, self._radius[spot] / TEXEL, color)
            self._draw_flash(part, k, scene.time)
            self._draw_shadows(part, screen, scene)
        return atlas

    def _draw_stripe(self, atlas: Array, time: float) -> None:
        """A bar of light that turns about the middle of the first screen."""
        first, last, columns = self.screens[0].window()
        angle = 0.4 * time
        middle, arm = (
            np.array([columns, last - first]) / 2,
            np.array([np.cos(angle), np.sin(angle)]) * columns,
        )
        color = self._colors[int(time / 4) % len(self._colors)] * 0.12
        a, b = (tuple(int(v) for v in middle + s * arm) for s in (-1, 1))
        cv2.line(atlas[first:last, :columns], a, b, color.tolist(), 9, cv2.LINE_AA)

    def _draw_flash(self, part: Array, screen: int, time: float) -> None:
        slot = int(time / SLOT)
        begin, where, radius, color = self._flash(screen, slot)
        if 0 <= time - slot * SLOT - begin < FLASH:
            _disc(part, where * part.shape[1::-1], radius, color)

    def _plan_flash(self, screen: int, slot: int) -> tuple[float, Array, float, Array]:
        """When the flash of a slot begins (s), where (of the screen), radius (texels), colour."""
        rng = np.random.default_rng([self._seed, 78, screen, slot])
        color = self._colors[rng.integers(len(self._colors))] * 0.8
        return rng.uniform(0, SLOT - FLASH), rng.uniform(0.2, 0.8, 2), rng.uniform(8, 40), color

    def _draw_shadows(self, part: Array, screen: Screen, scene: Scene) -> None:
        solid = SOLID[scene.part]
        shade, scale = screen.shadow(scene.limbs[solid].reshape(-1, 3))
        texel = (screen.texel(shade) - [0, screen.row]).reshape(-1, 4)
        thick = 2 * scene.radius[solid] * scale.reshape(-1, 2).mean(axis=1) / TEXEL
        near = np.abs(texel).max(axis=1) < 2000  # also leaves out what is not a number
        lines = np.round(np.column_stack([texel, thick])[near]).astype(int).tolist()
        for x1, y1, x2, y2, width in lines:
            cv2.line(part, (x1, y1), (x2, y2), (0, 0, 0), max(1, width))

    def _splash(self, frame: int) -> Splashes:
        """Spots that meet a body before they meet their screen."""
        scene = self.world.scene(frame)
        solid = np.flatnonzero(SOLID[scene.part])
        if len(solid) == 0:
            return NO_SPLASHES
        where, hits = self._spots(scene.time), []
        for k, screen in enumerate(self.screens):
            spots = np.flatnonzero(self._screen == k)
            aim = (screen.point(where[spots]) - screen.projector).T
            aim /= np.sqrt(np.square(aim).sum(axis=0))
            distance, along = approach(screen.projector, aim, scene.limbs[solid])
            thick = scene.radius[solid][:, None]
            entry = along - np.sqrt(np.maximum(thick * thick - distance * distance, 0.0))
            entry[distance >= thick] = np.inf
            first, go = entry.argmin(axis=0), entry.min(axis=0)
            met = np.isfinite(go)
            xyz = screen.projector + (aim[:, met] * go[met]).T
            target = self._target[spots[met]]
            hits.append((xyz, self._radius[spots[met]], self._colors[target] * 0.7, solid[first[met]]))
        xyz, radius, color, limb = (np.concatenate(column) for column in zip(*hits, strict=True))
        return Splashes(xyz, radius, color, limb)


def _disc(image: Array, centre: Array, radius: float, color: Array) -> None:
    """A disc at a place between pixels; places far outside are left out."""
    x, y = (round(v * (1 << SUBPIXEL)) for v in centre.tolist())
    if abs(x) + abs(y) < 1 << 16:
        cv2.circle(image, (x, y), round(radius * (1 << SUBPIXEL)), color.tolist(), -1, cv2.LINE_AA, SUBPIXEL)


def _scenery(size: tuple[int, int], colors: Array, rng: np.random.Generator) -> Array:
    """Soft clouds of coloured light, taller than the atlas so that they can drift: (H, W, 3) uint8."""
    rows, columns = size[0] + 80, size[1]
    coarse = rng.random((7, 5, len(colors))) ** 3
    coarse = coarse @ colors / len(colors) * 0.35
    return np.asarray(
        cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC).clip(0, 255).astype("u1")
    )
