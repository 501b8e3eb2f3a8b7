"""The interfering projections: moving spots in the balls' colours, stripes, flashes, shadows of people.

Colours are BGR, 0 to 255: linear light, but the values of colour cameras in `Shapes` and `Splashes`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from followspot import Array
from followspot_sim.body import PARTS
from followspot_sim.marks import MARKS
from followspot_sim.recent import Recent
from followspot_sim.rendering.moving_spots import MovingSpots
from followspot_sim.rendering.outline import stadiums
from followspot_sim.rendering.ray_casting import closest_approach, half_chord, unit
from followspot_sim.rendering.screen import atlas_size, screens_of
from followspot_sim.sensor import displayed
from followspot_sim.world import Scene, Setting, world_of

LAG = 0.25
"""By how much a trailing spot is behind its ball, s."""
SOLID = np.isin(PARTS + MARKS, ("leg", "torso", "head"))
"""Which parts of a body stop light (the others are too thin to matter)."""
SLOT, FLASH = 1.5, 0.08
"""A flash comes once in each slot and lasts that long, s."""
BENDS = 4
"""In how many pieces the stripe is drawn, for lenses bend it."""
PIECES = np.stack([np.linspace(-1, 1, BENDS + 1)[:-1], np.linspace(-1, 1, BENDS + 1)[1:]], axis=1)[..., None]
STRIPE_RADIUS, ON_FLOOR = np.full((BENDS, 2), 0.0675), np.zeros(BENDS, int)
"""Ends of the pieces, as a share of half its length; half its width, m; and its screen."""
NO_STROKES = (np.empty((0, 2, 2)), np.empty((0, 2)), np.empty(0, int), np.empty((0, 3)))
"""Ends (N, 2, 2) m along the axes of the screen, radius at each end (N, 2) m, screen (N,), colour (N, 3)."""
STRIPE_TURN, STRIPE_TIME = 0.4, 4.0
"""Turn rate of the stripe, rad/s, and the time for which it has one colour, s."""
STRIPE_LIGHT, FLASH_LIGHT, SPLASH_LIGHT = 0.12, 0.8, 0.7
"""Light of the stripe, of flashes and of spots on bodies, over that of a spot on a screen."""
FARTHEST_SHADOW = 30.0
"""Distance along a screen from which a shadow is left out, m."""
SHADE = 7.0
"""Colour of a shadowed screen in colour cameras."""
Strokes = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class Shapes:
    """Light and shadow on the screens, in painting order: outline (N, 14, 3) m, color: one a shape."""

    outline: Array
    color: list[list[float]]


@dataclass(frozen=True, eq=False)
class Splashes:
    """Spots that fall on bodies.

    xyz: (S, 3) m; outward: (S, 3) m, from the axis of the limb; radius: (S,) m; color: (S, 3); limb:
    (S,) number in the scene.
    """

    xyz: Array
    outward: Array
    radius: Array
    color: Array
    limb: Array


NO_SPLASHES = Splashes(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty((0, 3)), np.empty(0, int))


@dataclass(frozen=True)
class Lighting:
    """Parameters of the projections; equal ones give equal projections in every process.

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
    """The projected light, frame by frame; the last frames are cached for the next camera."""

    def __init__(self, lighting: Lighting) -> None:
        self.world = world_of(lighting.setting)
        self.screens = screens_of(lighting.planes)
        colors = np.array(lighting.colors).reshape(-1, 3)
        self.active = bool(lighting.spots and self.screens and len(colors))
        self.shapes = Recent(self._draw)
        self.splashes = Recent(self._splash)
        self._spots = Recent(self._place_spots)
        rng = np.random.default_rng([lighting.setting.seed, 77])
        self._colors = colors * lighting.brightness
        self._moving = MovingSpots.drawn(lighting.spots, len(colors), self.screens, rng)
        self._seed = lighting.setting.seed
        self._lag = round(LAG * lighting.setting.fps)
        self._flash = lru_cache(maxsize=8)(self._plan_flash)
        self._size = np.array([s.size for s in self.screens]).reshape(-1, 2)
        self._corner = np.array([s.corner for s in self.screens]).reshape(-1, 3)
        self._axes = np.array([s.axes for s in self.screens]).reshape(-1, 2, 3)
        self._scenery = _scenery(atlas_size(self.screens), self._colors, rng) if self.active else None

    def drift(self, frame: int) -> int:
        """By how many texels the clouds have drifted."""
        return round(40 * (1 + math.sin(0.35 * self.world.scene(frame).time)))

    def clouds(self, drift: int) -> Array:
        """The clouds on all screens, an atlas (H, W, 3) uint8."""
        assert self._scenery is not None  # not called without light
        return np.asarray(self._scenery[drift : drift + atlas_size(self.screens)[0]])

    def _place_spots(self, frame: int) -> Array:
        """Position of every spot on its screen, (N, 2) m along its axes."""
        balls = self.world.scene(max(frame - self._lag, 0)).balls
        return self._moving.places(self.world.scene(frame).time, balls, self.screens)

    def _draw(self, frame: int) -> Shapes:
        """All strokes of a frame, clipped to their screens."""
        scene = self.world.scene(frame)
        spots = np.repeat(self._spots(frame)[:, None], 2, axis=1)
        spot_radius = np.repeat(self._moving.radius[:, None], 2, axis=1)
        strokes = [
            self._stripe(scene.time),
            (spots, spot_radius, self._moving.screen, displayed(self._colors)[self._moving.target]),
            self._flashes(scene.time),
            self._shadows(scene),
        ]
        ends, radius, screen, color = _together(strokes)
        outline, size = stadiums(ends, radius), self._size[screen][:, None]
        lit = ((outline.max(axis=1) > 0) & (outline.min(axis=1) < size[:, 0])).all(axis=1)
        where, on = np.minimum(np.maximum(outline, 0), size)[lit], screen[lit]
        return Shapes(self._corner[on][:, None] + where @ self._axes[on], color[lit].tolist())

    def _stripe(self, time: float) -> Strokes:
        """A bar of light that turns about the middle of the first screen."""
        middle, angle = self._size[0] / 2, STRIPE_TURN * time
        arm = np.array([math.cos(angle), math.sin(angle)])
        arm *= (middle / np.maximum(np.abs(arm), 1e-9)).min()
        color = displayed(self._colors[int(time / STRIPE_TIME) % len(self._colors)] * STRIPE_LIGHT)
        return middle + PIECES * arm, STRIPE_RADIUS, ON_FLOOR, np.repeat(color[None], BENDS, axis=0)

    def _flashes(self, time: float) -> Strokes:
        """Large discs that appear for a moment."""
        slot, found = int(time / SLOT), [NO_STROKES]
        for screen, size in enumerate(self._size):
            begin, where, radius, color = self._flash(screen, slot)
            if 0 <= time - slot * SLOT - begin < FLASH:
                found.append(
                    (
                        np.tile(where * size, (1, 2, 1)),
                        np.full((1, 2), radius),
                        np.array([screen]),
                        color[None],
                    )
                )
        return _together(found)

    def _plan_flash(self, screen: int, slot: int) -> tuple[float, Array, float, Array]:
        """Flash of a slot: start (s), position (on the screen), radius (m), colour."""
        rng = np.random.default_rng([self._seed, 78, screen, slot])
        color = displayed(self._colors[rng.integers(len(self._colors))] * FLASH_LIGHT)
        return rng.uniform(0, SLOT - FLASH), rng.uniform(0.2, 0.8, 2), rng.uniform(0.12, 0.6), color

    def _shadows(self, scene: Scene) -> Strokes:
        """Shadows of bodies on the screens."""
        solid = SOLID[scene.part]
        ends, radius, found = scene.limbs[solid].reshape(-1, 3), scene.radius[solid][:, None], [NO_STROKES]
        for number, screen in enumerate(self.screens):
            shade, scale = screen.shadow(ends)
            where = screen.place(shade).reshape(-1, 2, 2)
            near = np.abs(where).max(axis=(1, 2)) < FARTHEST_SHADOW  # also excludes NaN
            thick = radius * scale.reshape(-1, 2)
            count = int(near.sum())
            found.append((where[near], thick[near], np.full(count, number), np.full((count, 3), SHADE)))
        return _together(found)

    def _splash(self, frame: int) -> Splashes:
        """Spots that meet a body before they meet their screen."""
        scene = self.world.scene(frame)
        solid = np.flatnonzero(SOLID[scene.part])
        if len(solid) == 0:
            return NO_SPLASHES
        where = self._spots(frame)[:, None] @ self._axes[self._moving.screen]
        projector = np.array([s.projector for s in self.screens])[self._moving.screen]
        aim, _ = unit(self._corner[self._moving.screen] + where[:, 0] - projector)
        ends, thick = scene.limbs[solid], scene.radius[solid]
        distance, along = closest_approach(projector[:, None], aim[:, None], ends)
        entry = np.where(distance < thick, along - half_chord(thick, distance), np.inf)
        spot, first = np.flatnonzero(np.isfinite(entry.min(axis=1))), entry.argmin(axis=1)
        limb = first[spot]
        xyz = projector[spot] + aim[spot] * entry[spot, limb][:, None]
        axis, start = ends[limb, 1] - ends[limb, 0], ends[limb, 0]
        share = ((xyz - start) * axis).sum(axis=1) / np.maximum(np.square(axis).sum(axis=1), 1e-9)
        outward = xyz - start - np.clip(share, 0, 1)[:, None] * axis
        return Splashes(
            xyz,
            outward,
            self._moving.radius[spot],
            self._colors[self._moving.target[spot]] * SPLASH_LIGHT,
            solid[limb],
        )


def _together(strokes: Sequence[Strokes]) -> Strokes:
    ends, radius, screen, color = (np.concatenate(column) for column in zip(*strokes, strict=True))
    return ends, radius, screen, color


def _scenery(size: tuple[int, int], colors: Array, rng: np.random.Generator) -> Array:
    """Soft clouds of coloured light, taller than the atlas so that they can drift: (H, W, 3) uint8."""
    rows, columns = size[0] + 80, size[1]
    coarse = rng.random((7, 5, len(colors))) ** 3
    coarse = coarse @ colors / len(colors) * 0.35
    return np.asarray(
        cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC).clip(0, 255).astype("u1")
    )
