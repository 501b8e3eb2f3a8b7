"""What one camera sees of a scene: the lit room, people, balls, and then the sensor."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array, Camera, Room
from followspot.geometry import project
from followspot_sim.ball_image import View, color_light, infrared_light, stamps
from followspot_sim.body import PARTS
from followspot_sim.light import NO_SPLASHES, Lighting, Splashes, show_of
from followspot_sim.parameters import SimParams
from followspot_sim.people_image import dot, fill, outlines
from followspot_sim.screen import fixed_point, lookup, rays_of
from followspot_sim.sensor import GAMMA, Sensor, linear, own_rng
from followspot_sim.world import Scene, World, setting, world_of

SHIRTS = np.array([[4, 4, 16], [10, 12, 14], [3, 9, 4], [14, 6, 3], [5, 12, 13], [8, 4, 9]], float)
"""Linear BGR of each person's shirt in the twilight of the room."""
TROUSERS, SKIN, BAG_CLOTH = [3.0, 3.0, 4.0], [6.0, 8.0, 13.0], [6.0, 6.0, 5.0]
GRAY = {"leg": 7.0, "torso": 16.0, "bag": 5.0, "head": 21.0, "arm": 14.0, "forearm": 20.0, "badge": 150.0}
"""Infrared light that each part of a body reflects."""
INFRARED_BALL, INFRARED_RANGE = 175.0, 5.5
"""Infrared light of a ball's patches at that distance (m); reflectors fall off slowly with distance."""


class Picture:
    """One camera's pictures of the simulated room, any frame at any time."""

    def __init__(self, params: SimParams, room: Room, camera: Camera) -> None:
        """Prepare all that stays: rays, the lookup of the screens, the dark room, the noise.

        Raises InputError where `alone` names no target of the room.
        """
        self.camera = camera
        self.world: World = world_of(setting(params, room))
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
                0 if params.alone else params.projections,
                params.projection_brightness,
                tuple(tuple(plane.tolist()) for plane in room.planes.values()),
                tuple(tuple(color) for color in light.tolist()),
            )
        )
        rays = rays_of(camera)
        self._view = View(
            camera.center,
            np.ascontiguousarray(rays.reshape(-1, 3).T, np.float32),
            camera.size,
            float(camera.matrix[0, 0]),
            margin=2 if infrared else 4,
        )
        place, number = lookup(camera, rays, self._show.screens)
        self._map = fixed_point(place)
        self._dark = _dark_room(number, infrared, rng).reshape(self.shape)
        self._tones = _tones(self._people, infrared)
        self._sensor = Sensor(self.shape, params.noise, 1.0 if infrared else GAMMA, rng)

    def render(self, frame: int, out: Array) -> None:
        """The picture of a frame into `out`, (H, W, C) uint8: BGR or one grey channel."""
        scene = self.world.scene(frame)
        light = self._dark.copy()
        splashes = NO_SPLASHES
        if self.shape[2] == 3 and self._show.active:
            self._project(light, frame)
            splashes = self._show.splashes(frame)
        if len(scene.limbs):
            self._draw_people(light, scene, splashes)
        self._draw_balls(light, scene)
        self._sensor.expose(light, frame, out)

    def _project(self, light: Array, frame: int) -> None:
        shown = cv2.remap(self._show.atlas(frame), *self._map, cv2.INTER_LINEAR)
        cv2.add(light, shown, dst=light)

    def _draw_people(self, light: Array, scene: Scene, splashes: Splashes) -> None:
        polygons, scale, order = outlines(self.camera, scene.limbs, scene.radius)
        struck = set(splashes.limb.tolist())
        pixel = project(self.camera, splashes.xyz)
        for limb in order.tolist():
            fill(light, polygons[limb], self._tones[limb])
            if limb in struck:
                for k in np.flatnonzero(splashes.limb == limb):
                    if self._faces(splashes.xyz[k], scene.limbs[limb]):
                        radius = min(splashes.radius[k], 0.8 * scene.radius[limb]) * scale[limb]
                        dot(light, pixel[k], radius, (splashes.color[k] * self._balance).tolist())

    def _faces(self, point: Array, limb: Array) -> bool:
        """Whether a point on a limb is on the side of the camera."""
        axis = limb[1] - limb[0]
        t = np.clip((point - limb[0]) @ axis / max(float(axis @ axis), 1e-9), 0.0, 1.0)
        return bool((point - limb[0] - t * axis) @ (self.camera.center - point) > 0)

    def _draw_balls(self, light: Array, scene: Scene) -> None:
        pixel = project(self.camera, scene.balls)
        seen = stamps(self._view, pixel, scene.balls, self._radii, scene.limbs, scene.radius)
        cover = seen.cover[..., None]
        if self.shape[2] == 3:
            glow = color_light(self._glow[seen.ball], seen.facing)
            added = glow * cover + seen.halo[..., None] * self._glow[seen.ball][:, None, None]
        else:
            brightness = INFRARED_BALL * INFRARED_RANGE / seen.distance
            added = infrared_light(brightness, seen.facing) * cover
        side = cover.shape[1]
        for (row, column), kept, plus in zip(seen.corner.tolist(), 1.0 - cover, added + 0.5, strict=True):
            area = light[row : row + side, column : column + side]
            area[...] = np.minimum(area * kept + plus, 255.0)


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
    """Light of every limb of every person, as long as the picture has channels."""
    if infrared:
        return [[GRAY[part] * (1 + 0.15 * (p % 3 - 1))] for p in range(people) for part in PARTS]
    cloth = {"leg": TROUSERS, "bag": BAG_CLOTH, "head": SKIN, "forearm": SKIN}
    return [cloth.get(part, SHIRTS[p % len(SHIRTS)].tolist()) for p in range(people) for part in PARTS]
