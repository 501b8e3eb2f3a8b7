"""The first particles of a person, from a detector's box."""

from __future__ import annotations

import numpy as np

from followspot import Array, Camera
from followspot.geometry import ray
from followspot_persons.body.standing import WAIST
from followspot_persons.body.stature import SPREAD, USUAL
from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT
from followspot_persons.hog.likelihood import heading_log_likelihood
from followspot_persons.likelihood.fitness import Detection
from followspot_persons.particles.condensation import systematic
from followspot_persons.particles.motion import limited

BOX_SIGMA = 0.08
"""Error of the size of a detected box, of its size."""
PLACE_SIGMA = 0.03
"""Error of its middle, of its height."""
NEAREST = 0.6
"""Distance of people from a camera, m."""
SMALLEST = 12.0
"""Smallest height of an upper body that can be tracked, px."""


def spawned(camera: Camera, detection: Detection, count: int, rng: np.random.Generator) -> Array:
    """Poses that fit the box, (count, 6), with headings from the detector.

    The rays of the box's top and bottom are as far apart as the upper body is high; the top gives the height.
    """
    x0, y0, x1, y1 = detection.box
    size = (y1 - y0) * np.exp(BOX_SIGMA * rng.standard_normal(count))
    column = (x0 + x1) / 2 + PLACE_SIGMA * (y1 - y0) * rng.standard_normal(count)
    middle = (y0 + y1) / 2 + PLACE_SIGMA * (y1 - y0) * rng.standard_normal(count)
    top = _slopes(camera, column, middle - size / 2)
    low = _slopes(camera, column, middle + size / 2)
    stature = USUAL + SPREAD * rng.standard_normal(count)
    apart = np.maximum(top[:, 2] - low[:, 2], 1e-3)
    by_size = stature * (1 - WAIST) / apart
    distance = np.clip(by_size, NEAREST, farthest(camera))
    pose = np.zeros((count, 6))
    pose[:, :2] = camera.center[:2] + distance[:, None] * top[:, :2]
    pose[:, HEIGHT] = camera.center[2] + distance * top[:, 2]
    bearing = np.arctan2(-top[:, 1], -top[:, 0])
    torso = _drawn(detection.torso, count, rng)
    head = _drawn(detection.head, count, rng)
    pose[:, HEADING] = bearing + torso
    pose[:, PAN] = (head - torso + np.pi) % (2 * np.pi) - np.pi
    pose[:, TILT] = 0.1 * rng.standard_normal(count)
    return limited(pose)


def farthest(camera: Camera) -> float:
    """Distance at which the upper body of an adult is `SMALLEST` px high, m; a long lens sees farther."""
    return float(camera.matrix[1, 1]) * USUAL * (1 - WAIST) / SMALLEST


def _slopes(camera: Camera, column: Array, row: Array) -> Array:
    """Rays scaled to one metre on the floor: (N, 3)."""
    direction = ray(camera, np.column_stack([column, row]))
    return np.asarray(direction / np.maximum(np.hypot(direction[:, 0], direction[:, 1]), 1e-6)[:, None])


def _drawn(table: Array, count: int, rng: np.random.Generator) -> Array:
    """Headings drawn from a table of log-likelihoods; any heading if there is none."""
    tried = rng.uniform(-np.pi, np.pi, 4 * count)
    weight = np.exp(heading_log_likelihood(table, tried))
    return np.asarray(tried[rng.permutation(systematic(weight / weight.sum(), count, rng))])
