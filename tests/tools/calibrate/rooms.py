"""Rooms made up for tests of calibrations: cameras on a truss that look at a waved bulb."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array
from followspot_calibrate.sightings import Sightings

SIZE = (640, 480)


@dataclass(frozen=True, eq=False)
class MadeRoom:
    """The truth, and what the cameras saw of it. points: (N, 3) m; outlier: (N, C) bool."""

    cameras: tuple[Camera, ...]
    points: Array
    sightings: Sightings
    outlier: Array


def made_room(
    cameras: int = 4,
    rows: int = 300,
    *,
    missing: float = 0.0,
    outliers: float = 0.0,
    noise: float = 0.0,
    distortion: tuple[float, ...] = (-0.15, 0.03, 0.001, -0.0005, 0.0),
    seed: int = 0,
) -> MadeRoom:
    """A room of 5 m with the cameras around it and the points in its middle.

    missing, outliers: shares of what the cameras could see; noise: px, one sigma.
    """
    random = np.random.default_rng(seed)
    ring = tuple(ring_camera(f"cam{i}", i / cameras, random, distortion) for i in range(cameras))
    points = random.uniform([-1.6, -1.6, 0.1], [1.6, 1.6, 2.0], (rows, 3))
    exact = np.stack([project(camera, points) for camera in ring], axis=1)
    pixel = exact + random.normal(0, 1, exact.shape) * noise
    outlier = random.random(pixel.shape[:2]) < outliers
    pixel[outlier] = random.uniform([0, 0], SIZE, (int(outlier.sum()), 2))
    unseen = (random.random(pixel.shape[:2]) < missing) | ((pixel < 0) | (pixel > SIZE)).any(axis=2)
    pixel[unseen] = np.nan
    names = tuple(camera.name for camera in ring)
    sizes = np.tile(SIZE, (cameras, 1))
    sightings = Sightings(names, sizes, np.arange(rows), np.zeros(rows, int), pixel)
    return MadeRoom(ring, points, sightings, outlier & ~unseen)


def ring_camera(
    name: str, around: float, random: np.random.Generator, distortion: tuple[float, ...]
) -> Camera:
    """A camera at a share of the way around the room, that looks at its middle; no two are quite alike."""
    angle = 2 * np.pi * around + random.uniform(-0.1, 0.1)
    center = np.array([3.2 * np.cos(angle), 3.2 * np.sin(angle), random.uniform(2.2, 3.2)])
    focal = random.uniform(420, 480)
    middle = np.array(SIZE) / 2 - 0.5 + random.uniform(-6, 6, 2)
    matrix = np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1]])
    rotation = looking(center, np.array([*random.uniform(-0.3, 0.3, 2), 0.9]))
    return Camera(name, "color", SIZE, matrix, np.array(distortion), rotation, -rotation @ center)


def looking(center: Array, at: Array) -> Array:
    """The rotation of a camera that looks from a centre at a point, with the picture's top upward."""
    forward = (at - center) / np.linalg.norm(at - center)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])
