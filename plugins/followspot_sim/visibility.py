"""How much of each ball every camera sees, and what follows for the ground truth."""

from __future__ import annotations

import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_sim.sight import blocked, disc
from followspot_sim.world import Scene

SAMPLES = disc(64)
"""Where the face of a ball is probed, in radii."""
HARD = 1e-6
"""Width of a capsule's edge for yes or no, m."""


def visible_fraction(camera: Camera, scene: Scene, radii: Array) -> Array:
    """Share of each ball's face that a camera sees: inside the picture and behind nothing.

    radii: (T,) m. Returns (T,), 0 to 1; 0 for balls that are not shown.
    """
    fraction = np.zeros(len(radii))
    capsules = np.concatenate([scene.limbs, np.repeat(scene.balls[:, None], 2, axis=1)])
    thickness = np.concatenate([scene.radius, radii])
    for ball in np.flatnonzero(~np.isnan(scene.balls[:, 0])):
        points = face(camera.center, scene.balls[ball], radii[ball])
        others = np.arange(len(capsules)) != len(scene.limbs) + ball
        others &= ~np.isnan(capsules[:, 0, 0])
        away = points - camera.center
        distance = np.linalg.norm(away, axis=1)
        hidden = blocked(
            camera.center, away / distance[:, None], distance, capsules[others], thickness[others], HARD
        )
        fraction[ball] = np.mean((hidden < 0.5) & inside(camera, points))
    return fraction


def face(eye: Array, centre: Array, radius: float) -> Array:
    """Points on the half of a ball that faces `eye`, evenly over its silhouette: (64, 3) m."""
    away = centre - eye
    distance = float(np.linalg.norm(away))
    forward = away / distance
    side = np.cross(forward, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    height = np.sqrt(1.0 - np.square(SAMPLES).sum(axis=1))
    across = SAMPLES @ np.stack([side, np.cross(side, forward)])
    return np.asarray(centre + radius * (across - height[:, None] * forward))


def inside(camera: Camera, points: Array) -> Array:
    """Whether points of the room fall into the picture, (N,) bool."""
    pixel = project(camera, points)
    width, height = camera.size
    edge = np.array([width, height]) - 0.5
    with np.errstate(invalid="ignore"):
        return np.asarray(np.all((pixel >= -0.5) & (pixel < edge), axis=1))


def judge(visible: Array, color: Array) -> tuple[Array, Array, Array]:
    """Hidden, trackable and pair, each (T,) bool, as `followspot.tracking.Truth` defines them.

    visible: (V, T) share seen by each camera; color: (V,) whether the camera is a colour camera.
    """
    hidden = np.all(visible < 0.05, axis=0)
    enough = visible >= 0.25
    trackable = (enough.sum(axis=0) >= 2) & enough[color].any(axis=0)
    half = visible >= 0.5
    return hidden, trackable, half[color].any(axis=0) & half[~color].any(axis=0)
