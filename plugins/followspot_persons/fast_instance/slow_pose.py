"""Poses that the slow instance reports for an earlier time, and particles about them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot_persons.particles.condensation import scattered
from followspot_persons.particles.track import MAXIMUM_SPEED

MAXIMUM_AGE = 2.0
"""Time after which a person may have turned round, s."""
SPAWN_SIGMA = np.array([0.06, 0.06, 0.03, 0.3, 0.3, 0.1])
"""Sigma of particles about a pose of the slow instance: m, m, m, rad, rad, rad."""
SIGMA_GROWTH = np.array([0.5, 0.5, 0.0, 0.8, 0.8, 0.2])
"""Growth of this sigma with the age of the pose: m/s, m/s, m/s, rad/s, rad/s, rad/s."""
ALONG, ACROSS = 0.8, 0.4
"""Distances from a pose of the slow instance, along and across the line of sight, from which the track was
another body's or furniture's, m; poses of the slow one are some decimetres off along it, hardly across."""


@dataclass(frozen=True, eq=False)
class SlowPose:
    """A pose (6,) of a person that the slow instance reported for a time, ns."""

    time: int
    pose: Array

    def velocity(self, before: SlowPose | None) -> Array:
        """Velocity (2,) m/s since the previous report, 0 without one of the last seconds."""
        apart = (self.time - before.time) * NANOSECOND if before is not None else np.inf
        if before is None or apart > MAXIMUM_AGE:
            return np.zeros(2)
        velocity = (self.pose[:2] - before.pose[:2]) / apart
        return np.asarray(velocity * min(1.0, MAXIMUM_SPEED / max(float(np.hypot(*velocity)), 1e-9)))

    def forecast(self, before: SlowPose | None, seconds: float) -> Array:
        """The pose some seconds later."""
        return np.concatenate([self.pose[:2] + self.velocity(before) * seconds, self.pose[2:]])


def halfway_distance(pose: Array, slow_pose: Array, eye: Array) -> Array:
    """The fast instance's pose, (6,), moved half way to the distance of the slow one's, (6,).

    Where feet do not tell the distance, each knows it with an error of its own. The fast one holds its last
    distance, so that particles at the slow one's would not survive. eye: (3,) m, the camera's centre.
    """
    own, other = (float(np.hypot(*(p[:2] - eye[:2]))) for p in (pose, slow_pose))
    out = pose.copy()
    out[:2] += (other - own) / (2 * max(own, 1e-6)) * (pose[:2] - eye[:2])
    return out


def is_other_body(then: Array, pose: Array, eye: Array) -> bool:
    """Whether a track has left the person whom the slow instance saw in a pose.

    then: (6,) the track's pose at that time; pose: (6,) of the slow instance; eye: (3,) m, the camera's
    centre.
    """
    sight = pose[:2] - eye[:2]
    sight, apart = sight / max(float(np.hypot(*sight)), 1e-6), (then - pose)[:2]
    along, across = sight @ apart, sight[0] * apart[1] - sight[1] * apart[0]
    return bool(np.hypot(along / ALONG, across / ACROSS) > 1)


def particles_about(pose: Array, count: int, rng: np.random.Generator, age: float = 0.0) -> Array:
    """Particles about a pose `age` seconds old, (count, 6); some are turned, for headings are often wrong."""
    sigma = np.hypot(SPAWN_SIGMA, age * SIGMA_GROWTH)
    particles = pose + sigma * rng.standard_normal((count, 6))
    turned = count // 5
    particles[:turned] = scattered(particles[:turned], rng)
    return np.asarray(particles)
