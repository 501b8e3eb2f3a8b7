"""The visible share of each ball in every camera, and the flags of the ground truth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Array, Camera
from followspot.geometry import project
from followspot_sim.rendering.ray_casting import closest_approach, half_chord, sunflower_disc, unit
from followspot_sim.world import Scene

SAMPLES = sunflower_disc(64)
"""Sampled points of the face of a ball, in radii."""
HEIGHTS = np.sqrt(1.0 - np.square(SAMPLES).sum(axis=1))
"""Offsets of these points towards the camera, in radii."""
ROUNDING = 1e-6
"""The face lies on its own ball; lines of sight stop that much before it, m."""


def visible_fraction(cameras: Sequence[Camera], scene: Scene, radii: Array) -> Array:
    """Share of each ball's face that each camera sees: inside the picture and behind nothing.

    radii: (T,) m. Returns (V, T), 0 to 1; 0 for balls that are not shown.
    """
    shown = np.flatnonzero(~np.isnan(scene.balls[:, 0]))
    centres, radius = scene.balls[shown], radii[shown]
    eyes = np.array([camera.center for camera in cameras]).reshape(-1, 1, 3)
    forward, distance = unit(centres - eyes)
    points = facing_points(centres, radius, forward)
    seen = np.empty(points.shape[:3], bool)
    for k, camera in enumerate(cameras):
        seen[k] = _inside(camera, centres, points[k], 2.0 * camera.matrix[0, 0] * radius / distance[k])
    ends = np.concatenate([scene.limbs, np.repeat(centres[:, None], 2, axis=1)])
    thick = np.concatenate([scene.radius, radius])
    gap, along = closest_approach(eyes[:, :, None], forward[:, :, None], ends)
    near = (gap < thick + 1.2 * radius[:, None]) & (along - thick < distance[..., None])
    near[:, np.arange(len(shown)), len(scene.limbs) + np.arange(len(shown))] = False
    _clear_hidden(seen, np.nonzero(near), points, eyes, ends, thick)
    fraction = np.zeros((len(cameras), len(radii)))
    fraction[:, shown] = seen.mean(axis=2)
    return fraction


def _clear_hidden(
    seen: Array, near: tuple[Array, ...], points: Array, eyes: Array, ends: Array, thick: Array
) -> None:
    """Clear points in `seen` (V, T, 64) that capsules hide; near: camera, ball, capsule to test, sorted."""
    camera, ball, other = near
    if len(camera) == 0:
        return
    rays, reach = unit(points[camera, ball] - eyes[camera])
    gap, along = closest_approach(eyes[camera], rays, ends[other][:, None])
    within = thick[other][:, None]
    hit = (gap < within) & (along - half_chord(within, gap) < reach - ROUNDING)
    first = np.flatnonzero(np.diff(camera * len(points[0]) + ball, prepend=-1))
    seen[camera[first], ball[first]] &= ~np.logical_or.reduceat(hit, first, axis=0)


def facing_points(centres: Array, radii: Array, forward: Array) -> Array:
    """Points on the half of each ball that faces the camera, evenly over its silhouette.

    centres: (T, 3) m; radii: (T,) m; forward: (V, T, 3) unit vectors from the cameras to the centres.
    Returns (V, T, 64, 3) m.
    """
    x, y, z = forward[..., 0], forward[..., 1], forward[..., 2]
    level = np.maximum(np.hypot(x, y), 1e-9)
    frame = np.empty((*forward.shape[:2], 3, 3))  # rows: to the side, up, towards the camera
    frame[..., 0, 0], frame[..., 0, 1], frame[..., 0, 2] = y / level, -x / level, 0.0
    frame[..., 1, 0], frame[..., 1, 1], frame[..., 1, 2] = -x * z / level, -y * z / level, level
    frame[..., 2, :] = -forward
    local = np.column_stack([SAMPLES, HEIGHTS])
    return np.asarray(centres[:, None] + radii[:, None, None] * (local @ frame))


def _inside(camera: Camera, centres: Array, points: Array, margin: Array) -> Array:
    """Whether points on balls are in the picture: centres (T, 3), points (T, S, 3) m -> (T, S) bool.

    For a ball that is farther than its margin, (T,) px, from the border its centre decides.
    """
    pixel = project(camera, centres)
    size = np.array(camera.size) - 0.5
    with np.errstate(invalid="ignore"):
        whole = np.all((pixel > margin[:, None]) & (pixel < size - margin[:, None]), axis=1)
        found = np.repeat(whole[:, None], points.shape[1], axis=1)
        for ball in np.flatnonzero(~whole):
            pixel = project(camera, points[ball])
            found[ball] = ((pixel >= -0.5) & (pixel < size)).all(axis=1)
    return found


def truth_flags(visible: Array, cameras: Sequence[Camera]) -> tuple[Array, Array, Array]:
    """Hidden, trackable and pair, each (T,) bool, as `followspot.tracking.Truth` defines them.

    visible: (V, T) share seen by each camera.
    """
    color, infrared, depth = (
        np.array([camera.kind == kind for camera in cameras], bool) for kind in ("color", "infrared", "depth")
    )
    hidden = np.all(visible < 0.05, axis=0)
    enough, half = visible >= 0.25, visible >= 0.5
    trackable, pair = enough.sum(axis=0) >= 2, half.sum(axis=0) >= 2
    if color.any():
        trackable &= enough[color].any(axis=0)
        if infrared.any():
            pair = half[color].any(axis=0) & half[infrared].any(axis=0)
    trackable |= enough[depth].any(axis=0)
    pair |= half[depth].any(axis=0)
    return np.asarray(hidden), np.asarray(trackable), np.asarray(pair)
