"""The depth image of one camera of a scene: planes, people and balls, and then the errors of the sensor."""

from __future__ import annotations

import math

import numpy as np

from followspot import Array, Camera, Room
from followspot.geometry import project
from followspot_sim.parameters import DepthCameraParams
from followspot_sim.rendering.camera_rays import CameraRays, camera_rays
from followspot_sim.rendering.ray_casting import first_hit
from followspot_sim.rendering.screen import rays_of
from followspot_sim.sensor import POOL, own_rng
from followspot_sim.world import World, setting, world_of

MARGIN = 2.0
"""Pixels around the outline of a limb or ball that are looked through."""


class DepthPicture:
    """One depth camera's images of the simulated room, any frame at any time."""

    def __init__(self, params: DepthCameraParams, room: Room, camera: Camera) -> None:
        """Prepare the empty room and the noise. Raises InputError as `check_targets`."""
        self.shape = (camera.size[1], camera.size[0])
        self._camera, self._params = camera, params
        self.world: World = world_of(setting(params, room, params.clock_offset))
        self._radii = np.array([t.radius for t in room.targets.values()])
        rays = rays_of(camera)
        self._view = camera_rays(camera, rays)
        self._rays = rays
        self._ahead = np.maximum(rays @ camera.rotation[2], 0.0)
        self._empty = _planes(camera, rays, [np.asarray(plane) for plane in room.planes.values()])
        rng = own_rng(params.seed, camera.name)
        pool = (self.shape[0] + POOL, self.shape[1] + POOL)
        self._noise = rng.normal(0.0, 1.0, pool).astype(np.float32)
        self._luck = rng.uniform(0.0, 1.0, pool).astype(np.float32)
        self._seed = int(rng.integers(1 << 31))

    def exact(self, frame: int) -> Array:
        """Depth along the optical axis without errors, (H, W) m; infinite if the pixel sees no surface."""
        scene = self.world.scene(frame)
        shown = ~np.isnan(scene.balls[:, 0])
        balls = np.repeat(scene.balls[shown, None], 2, axis=1)
        reach = self._empty.copy()
        ends, radii = np.concatenate([scene.limbs, balls]), np.concatenate([scene.radius, self._radii[shown]])
        for window, end, radius in _windows(self._view, ends, radii):
            seen = first_hit(self._camera.center, self._rays[window], end, radius)
            np.minimum(reach[window], seen, out=reach[window])
        with np.errstate(invalid="ignore"):
            return np.where(self._ahead > 0, reach * self._ahead, np.inf)

    def render(self, frame: int, out: Array) -> None:
        """The depth image of a frame, as the sensor measures it, into `out`, (H, W) float32 m."""
        p, depth = self._params, self.exact(frame)
        down, right = ((self._seed + frame) * step % 1000003 % POOL for step in (7919, 104729))
        window = (slice(down, down + self.shape[0]), slice(right, right + self.shape[1]))
        measured = depth <= p.maximum_depth
        depth[~measured] = p.maximum_depth
        share = np.where(_edges(depth, p.edge_step), p.edge_hole_share, p.hole_share)
        measured &= self._luck[window] >= share
        depth += (p.depth_sigma + p.depth_sigma_growth * depth * depth) * self._noise[window]
        out[:] = np.where(measured, np.maximum(depth, 0.0), 0.0)


def _planes(camera: Camera, rays: Array, planes: list[Array]) -> Array:
    """Distance along each ray to the nearest plane that the camera is in front of, (H, W) m; inf for none."""
    nearest = np.full(rays.shape[:2], np.inf)
    for plane in planes:
        facing = plane if plane @ [0.0, 0.0, 1.0, 1.0] > 0 else -plane
        height, closing = facing[:3] @ camera.center + facing[3], rays @ facing[:3]
        if height > 0:
            distance = np.where(closing < -1e-3, height / -np.minimum(closing, -1e-3), np.inf)
            np.minimum(nearest, distance, out=nearest)
    return nearest


def _windows(view: CameraRays, ends: Array, radii: Array) -> list[tuple[tuple[slice, slice], Array, float]]:
    """The part of the picture that each capsule may fill; those behind the camera or beside it are left out.

    ends: (K, 2, 3) m; radii: (K,) m. A limb of which one end has no image is left out too.
    """
    width, height = view.camera.size
    pixel = project(view.camera, ends.reshape(-1, 3)).reshape(-1, 2, 2)
    distance = np.linalg.norm(ends - view.camera.center, axis=2).min(axis=1)
    found = []
    for k in np.flatnonzero(np.isfinite(pixel).all(axis=(1, 2)) & (distance > radii)).tolist():
        nearest = np.clip(np.rint(pixel[k]).astype(int), 0, [width - 1, height - 1])
        pitch = float(view.pitch[nearest[:, 1] * width + nearest[:, 0]].min())
        reach = math.tan(min(math.asin(radii[k] / distance[k]), 1.5)) / pitch * 1.2 + MARGIN
        left, top = np.floor(pixel[k].min(axis=0) - reach).clip(0, [width, height]).astype(int).tolist()
        right, below = np.ceil(pixel[k].max(axis=0) + reach + 1).clip(0, [width, height]).astype(int).tolist()
        if left < right and top < below:
            found.append(((slice(top, below), slice(left, right)), ends[k], float(radii[k])))
    return found


def _edges(depth: Array, step: float) -> Array:
    """Pixels beside a step of the depth, on both sides of it: (H, W) bool."""
    found = np.zeros(depth.shape, bool)
    down = np.abs(np.diff(depth, axis=0)) > step
    right = np.abs(np.diff(depth, axis=1)) > step
    found[1:] |= down
    found[:-1] |= down
    found[:, 1:] |= right
    found[:, :-1] |= right
    return found
