"""The picture of one camera of a scene: the lit room, people, balls, and then the sensor."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from followspot import Array, Camera, Room
from followspot.geometry import project
from followspot_sim.body import PARTS
from followspot_sim.marks import MARKS
from followspot_sim.parameters import SimParams
from followspot_sim.rendering.ball_image import Stamps, color_light, compose, infrared_light
from followspot_sim.rendering.camera_rays import camera_rays
from followspot_sim.rendering.light import NO_SPLASHES, Lighting, Splashes, show_of
from followspot_sim.rendering.outline import CORNERS, fill, fixed_point, spot
from followspot_sim.rendering.people_image import Outlines
from followspot_sim.rendering.projected_scene import projected_scene
from followspot_sim.rendering.ray_casting import dot
from followspot_sim.rendering.screen import lookup, rays_of, remapping
from followspot_sim.sensor import DISPLAYED, Sensor, displayed, linear, own_rng
from followspot_sim.world import Scene, World, setting, world_of

SHIRTS = np.array([[4, 4, 16], [10, 12, 14], [3, 9, 4], [14, 6, 3], [5, 12, 13], [8, 4, 9]], float)
"""Linear BGR of each person's shirt in the twilight of the room."""
TROUSERS, SKIN, BAG_CLOTH = [3.0, 3.0, 4.0], [6.0, 8.0, 13.0], [6.0, 6.0, 5.0]
GRAY = {"leg": 7.0, "torso": 16.0, "bag": 5.0, "head": 21.0, "arm": 14.0, "forearm": 20.0, "badge": 150.0}
"""Infrared light that each part of a body reflects."""
REFLECTOR, CLOTH, PATCH = 230.0, [5.0, 5.0, 5.0], 0.6
"""Infrared light and colour of what reflects on clothes; colour of a patch over that of a ball."""
INFRARED_BALL, INFRARED_RANGE = 175.0, 5.5
"""Infrared light of a ball's patches at that distance (m); reflectors fall off slowly with distance."""

GRAIN = 2.0
"""How much stronger noise is in colour: gamma lifts it in the dark."""
FAINT = 50.0
"""Brightness below which edges are hard: that is invisible, and takes half the time."""

Spot = tuple[list[float], float, list[float]]
"""Centre and radius in px, colour."""


class Picture:
    """One camera's pictures of the simulated room, any frame at any time."""

    def __init__(self, params: SimParams, room: Room, camera: Camera, clock_offset: float = 0.0) -> None:
        """Prepare all that stays: rays, the lookup of the screens, the dark room, the noise.

        clock_offset: how much later than the frame's time the pictures are taken, s.
        Raises InputError if a parameter names no target of the room.
        """
        self.camera = camera
        self.world: World = world_of(setting(params, room, clock_offset))
        self._radii = np.array([t.radius for t in room.targets.values()])
        self._people = self.world.setting.people
        rng = own_rng(params.seed, camera.name)
        infrared = camera.kind == "infrared"
        self.shape = (camera.size[1], camera.size[0], 1 if infrared else 3)
        rgb = np.array([params.color(name, k) for k, name in enumerate(room.targets)]).reshape(-1, 3)
        light = linear(rgb[:, ::-1])
        self._balance = rng.uniform(0.93, 1.07, 3)
        self._glow = (light * self._balance * 1.1).clip(0, 255).astype(np.float32)
        self._show = show_of(
            Lighting(
                self.world.setting,
                0 if params.only_target else params.projections,
                params.projection_brightness,
                tuple(tuple(plane.tolist()) for plane in room.planes.values()),
                tuple(tuple(color) for color in light.tolist()),
            )
        )
        rays = rays_of(camera)
        self._view = camera_rays(camera, rays)
        self._widest = float((rays @ camera.rotation[2]).min()) - 0.1  # beyond, a lens model means nothing
        place, number = lookup(camera, rays, self._show.screens)
        self._map = remapping(place)
        self._unlit = _dark_room(number, infrared, rng).reshape(self.shape[: 2 if infrared else 3])
        self._dark = self._unlit if infrared else cv2.LUT(self._unlit, DISPLAYED)
        self._tones = _tones(self._people, infrared)
        if params.cover_balls:
            self._tones += _mark_tones(self._people, infrared, light * self._balance)
        self._bright = [max(tone) > FAINT for tone in self._tones]
        self._sensor = Sensor(self.shape, params.noise_sigma * (1 if infrared else GRAIN), rng)
        self._clouds = lru_cache(maxsize=2)(self._look_at_clouds)

    def render(self, frame: int, out: Array) -> None:
        """The picture of a frame into `out`, (H, W, C) uint8: BGR or one grey channel."""
        scene = self.world.scene(frame)
        seen = projected_scene(self._view, scene, self._radii)
        splashes = NO_SPLASHES
        if self.shape[2] == 3 and self._show.active:
            light = self._project(frame)
            splashes = self._show.splashes(frame)
        else:
            light = self._dark.copy()
        self._draw_people(light, scene, seen.people, splashes)
        self._draw_balls(light, seen.balls)
        self._sensor.expose(light, frame, out)

    def _look_at_clouds(self, drift: int) -> Array:
        """The room in the light of the clouds, which drift so slowly that many pictures share them."""
        light = cv2.remap(self._show.clouds(drift), *self._map, cv2.INTER_LINEAR)
        return np.asarray(cv2.LUT(cv2.add(light, self._unlit, dst=light), DISPLAYED))

    def _project(self, frame: int) -> Array:
        """The room in the light of all projections."""
        light = self._clouds(self._show.drift(frame)).copy()
        shapes = self._show.shapes(frame)
        away = shapes.outline - self.camera.center
        ahead = away @ self.camera.rotation[2] > self._widest * np.sqrt(dot(away, away))
        shown = np.flatnonzero(ahead.all(axis=1))
        pixel = fixed_point(project(self.camera, shapes.outline[shown].reshape(-1, 3)))
        for number, polygon in zip(shown.tolist(), pixel.reshape(len(shown), CORNERS, 2), strict=True):
            fill(light, polygon, shapes.color[number], soft=max(shapes.color[number]) > FAINT)
        return light

    def _draw_people(self, light: Array, scene: Scene, people: Outlines, splashes: Splashes) -> None:
        struck = self._struck(scene, people, splashes) if len(splashes.limb) else {}
        for limb in people.order:
            fill(light, people.polygon[limb], self._tones[limb], soft=self._bright[limb])
            for centre, radius, tone in struck.get(limb, ()):
                spot(light, centre, radius, tone)

    def _struck(self, scene: Scene, people: Outlines, splashes: Splashes) -> dict[int, list[Spot]]:
        """For each limb that light falls on, the spots on the side of the camera."""
        facing = dot(splashes.outward, self.camera.center - splashes.xyz) > 0
        limb = splashes.limb[facing]
        centre = project(self.camera, splashes.xyz[facing]).tolist()
        radius = np.minimum(splashes.radius[facing], 0.8 * scene.radius[limb]) * people.scale[limb]
        tone = displayed(splashes.color[facing] * self._balance).tolist()
        struck: dict[int, list[Spot]] = {}
        for number, *each in zip(limb.tolist(), centre, radius.tolist(), tone, strict=True):
            struck.setdefault(number, []).append((each[0], each[1], each[2]))
        return struck

    def _draw_balls(self, light: Array, seen: Stamps) -> None:
        if self.shape[2] == 3:
            compose(light, seen, color_light(seen, self._glow))
        else:
            compose(light, seen, infrared_light(seen, INFRARED_BALL * INFRARED_RANGE / seen.distance))


def _dark_room(number: Array, infrared: bool, rng: np.random.Generator) -> Array:
    """The room without balls and projections: faintly lit screens with a grain, black around them."""
    levels = np.array([12.0, 7.0]) if infrared else np.array([3.0, 2.0])
    height, width = number.shape
    y, x = np.mgrid[:height, :width]
    fall = 1.0 - 0.35 * ((x / width - 0.5) ** 2 + (y / height - 0.5) ** 2) * 4
    grain = cv2.resize(rng.uniform(0.85, 1.15, (height // 6, width // 6)), (width, height))
    level = np.where(number < 0, 0.0, levels[np.minimum(np.maximum(number, 0), 1)])
    gray = (level * fall * grain).round().astype(np.uint8)[..., None]
    return np.asarray(gray if infrared else np.repeat(gray, 3, axis=2))


def _tones(people: int, infrared: bool) -> list[list[float]]:
    """Colours of every limb of every person, one value for each channel of the picture."""
    if infrared:
        return [[GRAY[part] * (1 + 0.15 * (p % 3 - 1))] for p in range(people) for part in PARTS]
    cloth = {"leg": TROUSERS, "bag": BAG_CLOTH, "head": SKIN, "forearm": SKIN}
    light = [cloth.get(part, SHIRTS[p % len(SHIRTS)]) for p in range(people) for part in PARTS]
    return [displayed(tone).tolist() for tone in light]


def _mark_tones(people: int, infrared: bool, balls: Array) -> list[list[float]]:
    """Colours of every mark of every person, likewise; every second person wears reflectors.

    balls: (T, 3) linear BGR of the balls.
    """
    if infrared:
        shining = [[REFLECTOR if p % 2 == 0 else GRAY["arm"]] for p in range(people)]
        return [[GRAY["arm"]] if mark == "patch" else tone for tone in shining for mark in MARKS]
    found = []
    for number, mark in enumerate(MARKS * people):
        is_patch = mark == "patch" and len(balls) > 0
        tone = PATCH * balls[number % len(balls)] if is_patch else np.array(CLOTH)
        found.append(displayed(tone).tolist())
    return found
