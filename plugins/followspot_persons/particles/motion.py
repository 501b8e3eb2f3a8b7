"""The motion of people between two pictures, and the limits of their joints (Weinrich et al. 2010, section
4).
"""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT

MAX_PAN, MAX_TILT = 1.3, 0.7
"""Limits of pan and tilt of a neck, rad."""
LOWEST, HIGHEST = 1.2, 2.2
"""Heights of standing people, m."""
STEP = 0.6
"""One sigma of the change of velocity within a picture's time, m/s."""
CREEP = 0.01
"""Sigma of the motion at zero time: error of the last position, m."""
STRETCH = 0.1
"""One sigma of the height's change, m/s."""
TURN, SPIN = 1.0, 4.0
"""One sigma of a turn, most of the time and now and then, rad/s."""
SPIN_SHARE = 0.3
NECK, NOD = 3.0, 1.0
"""One sigma of the change of pan and tilt, rad/s."""


def predicted(
    pose: Array, velocity: Array, seconds: float, camera_center: Array, rng: np.random.Generator
) -> Array:
    """Poses after some time, each moved at random. pose: (N, 6); velocity: (2,) m/s. Returns (N, 6)."""
    count = len(pose)
    noise = rng.standard_normal((count, 6))
    out = pose.copy()
    radial = pose[:, :2] - camera_center[:2]
    distance = np.maximum(np.hypot(radial[:, 0], radial[:, 1]), 1e-6)[:, None]
    radial = radial / distance
    lateral = np.column_stack([-radial[:, 1], radial[:, 0]])
    step = CREEP + STEP * seconds
    out[:, :2] += velocity * seconds + step * (noise[:, :1] * lateral + 1.5 * noise[:, 1:2] * radial)
    out[:, HEIGHT] += STRETCH * seconds * noise[:, 2]
    rate = np.where(rng.random(count) < SPIN_SHARE, SPIN, TURN)
    out[:, HEADING] += rate * seconds * noise[:, 3]
    out[:, PAN] += NECK * seconds * noise[:, 4]
    out[:, TILT] += NOD * seconds * noise[:, 5]
    return limited(out)


def limited(pose: Array) -> Array:
    """Poses within the limits of joints and of people's heights; changes `pose` in place and returns it."""
    np.clip(pose[:, HEIGHT], LOWEST, HIGHEST, out=pose[:, HEIGHT])
    np.clip(pose[:, PAN], -MAX_PAN, MAX_PAN, out=pose[:, PAN])
    np.clip(pose[:, TILT], -MAX_TILT, MAX_TILT, out=pose[:, TILT])
    return pose
