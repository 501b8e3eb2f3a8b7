"""How much of each ball every camera sees, and what follows for the ground truth."""

from __future__ import annotations

import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_sim.sight import approach, blocked, disc
from followspot_sim.world import Scene

SAMPLES = disc(64)
"""Where the face of a ball is probed, in radii."""
HARD = 1e-6
"""Width of a capsule's edge for yes or no, m."""


def visible_fraction(camera: Camera, scene: Scene, radii: Array) -> Array:
    """Share of each ball's face that a camera sees: inside the picture and behind nothing.

    radii: (T,) m. Returns (T,), 0 to 1; 0 for balls that are not shown.
    """
    shown = np.flatnonzero(~np.isnan(scene.balls[:, 0]))
    centres, radius = scene.balls[shown], radii[shown]
    points = faces(camera.center, centres, radius).reshape(-1, 3)
    away = (points - camera.center).T
    distance = np.sqrt(np.square(away).sum(axis=0))
    rays = away / distance
    ends = np.concatenate([scene.limbs, np.repeat(centres[:, None], 2, axis=1)])
    thick = np.concatenate([scene.radius, radius])
    seen: Array = inside(camera, points)
    middle = (centres - camera.center).T
    middle /= np.sqrt(np.square(middle).sum(axis=0))
    near = approach(camera.center, middle, ends)[0] < thick[:, None] + 1.2 * radius
    near[len(scene.limbs) :] &= ~np.eye(len(shown), dtype=bool)
    close = near.any(axis=1)
    if close.any():  # the face lies on its own ball, so it stops just before, lest the ball hide itself
        seen[:] &= blocked(camera.center, rays, distance - HARD, ends[close], thick[close], HARD) < 0.5
    fraction = np.zeros(len(radii))
    fraction[shown] = seen.reshape(len(shown), -1).mean(axis=1)
    return fraction


def faces(eye: Array, centres: Array, radii: Array) -> Array:
    """Points on the half of each ball that faces `eye`, evenly over its silhouette.

    eye: (3,) m; centres: (T, 3) m; radii: (T,) m. Returns (T, 64, 3) m.
    """
    away = centres - eye
    forward = away / np.sqrt(np.square(away).sum(axis=1, keepdims=True))
    x, y, z = forward.T
    level = np.maximum(np.hypot(x, y), 1e-9)
    side = np.stack([y, -x, np.zeros_like(x)], axis=1) / level[:, None]
    up = np.stack([-x * z, -y * z, level * level], axis=1) / level[:, None]
    height = np.sqrt(1.0 - np.square(SAMPLES).sum(axis=1))
    across = SAMPLES[:, :1] * side[:, None] + SAMPLES[:, 1:] * up[:, None]
    return np.asarray(centres[:, None] + radii[:, None, None] * (across - height[:, None] * forward[:, None]))


def inside(camera: Camera, points: Array) -> Array:
    """Whether points of the room fall into the picture, (N,) bool."""
    pixel = project(camera, points)
    with np.errstate(invalid="ignore"):
        return np.asarray(((pixel >= -0.5) & (pixel < np.array(camera.size) - 0.5)).all(axis=1))


def judge(visible: Array, color: Array) -> tuple[Array, Array, Array]:
    """Hidden, trackable and pair, each (T,) bool, as `followspot.tracking.Truth` defines them.

    visible: (V, T) share seen by each camera; color: (V,) whether the camera is a colour camera.
    """
    hidden = np.all(visible < 0.05, axis=0)
    enough = visible >= 0.25
    trackable = (enough.sum(axis=0) >= 2) & enough[color].any(axis=0)
    half = visible >= 0.5
    pair = half[color].any(axis=0) & half[~color].any(axis=0)
    return np.asarray(hidden), np.asarray(trackable), np.asarray(pair)
