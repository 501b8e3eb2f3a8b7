"""Local gradient ascent, one coordinate after the other (Weinrich et al. 2010, section 4)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from followspot import Array
from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT
from followspot_persons.particles.motion import limited

ACROSS, DISTANCE, STATURE = range(3)
STEPS = {ACROSS: 0.03, DISTANCE: 0.12, STATURE: 0.02, HEADING: 0.25, PAN: 0.25, TILT: 0.12}
"""Steps of the first round, m and rad. The distance changes with the head's top kept at its place in the
picture, for along that line the picture changes least."""
FINEST = 1 / 8
"""Share of these steps at which a pose has converged."""


def ascend(
    pose: Array, value: Array, fitness: Callable[[Array], Array], eye: Array, rounds: int
) -> tuple[Array, Array]:
    """Poses moved uphill and their fitness: at most this number of rounds over all coordinates.

    A pose that a round did not improve has half the step in the next one, and is at its maximum when its step
    is `FINEST` of the first. pose: (P, 6) x, y, height (m), heading, pan, tilt (rad); value: (P,) their
    fitness; eye: (3,) m, the camera.
    """
    pose, value, size = pose.copy(), value.copy(), np.ones(len(pose))
    for _ in range(rounds):
        going = np.flatnonzero(size > FINEST)
        if not len(going):
            break
        higher, reached = pose[going], value[going]
        for coordinate, step in STEPS.items():
            higher, reached = _climb(higher, reached, fitness, eye, coordinate, size[going] * step)
        size[going] = np.where(reached > value[going], size[going], size[going] / 2)
        pose[going], value[going] = higher, reached
    return pose, value


def _climb(
    pose: Array,
    value: Array,
    fitness: Callable[[Array], Array],
    eye: Array,
    coordinate: int,
    step: Array,
) -> tuple[Array, Array]:
    """The best of each pose and its two neighbours along one coordinate."""
    tried = np.concatenate([moved(pose, eye, coordinate, step), moved(pose, eye, coordinate, -step)])
    values = fitness(tried).reshape(2, -1)
    better = values.argmax(axis=0)
    rows = np.arange(len(pose))
    best = values[better, rows]
    up = best > value
    pose = np.where(up[:, None], tried.reshape(2, -1, 6)[better, rows], pose)
    return pose, np.where(up, best, value)


def moved(pose: Array, eye: Array, coordinate: int, step: float | Array) -> Array:
    """Copies of poses, moved along one coordinate of `STEPS`. step: of all, or (P,) one each."""
    out = pose.copy()
    if coordinate in (ACROSS, DISTANCE):
        radial = pose[:, :2] - eye[:2]
        distance = np.maximum(np.hypot(radial[:, 0], radial[:, 1]), 1e-6)[:, None]
        unit = radial / distance
        if coordinate == ACROSS:
            out[:, 0] -= step * unit[:, 1]
            out[:, 1] += step * unit[:, 0]
        else:
            out[:, 0] += step * unit[:, 0]
            out[:, 1] += step * unit[:, 1]
            out[:, HEIGHT] += (pose[:, HEIGHT] - eye[2]) * step / distance[:, 0]
    else:
        out[:, coordinate] += step
    return limited(out)
