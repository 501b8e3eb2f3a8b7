"""Rooms made up for tests of calibrations: cameras on a truss that look at a waved bulb."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from followspot import Camera
from followspot.geometry import project
from followspot.messages import Array
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.similarity import similarity
from followspot_calibrate.wand.incremental_sfm import zoomed

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
    return _seen(ring, points, exact, random, missing, outliers, noise)


def waved_room(
    cameras: int = 5,
    rows: int = 500,
    *,
    late: Mapping[int, float] | None = None,
    zooms: Mapping[int, float] | None = None,
    height: tuple[float, float] = (0.1, 2.0),
    missing: float = 0.0,
    outliers: float = 0.0,
    noise: float = 0.4,
    seed: int = 0,
) -> MadeRoom:
    """The same room with one bulb on a smooth way through it, at up to 3 m/s and 30 pictures a second.

    late: by how many frames cameras take their pictures after the others; zooms: how many times as long
    the focal lengths of cameras are; height: of the way, m.
    """
    random = np.random.default_rng(seed)
    lens = (-0.15, 0.03, 0.001, -0.0005, 0.0)
    ring = tuple(ring_camera(f"cam{i}", i / cameras, random, lens) for i in range(cameras))
    ring = tuple(zoomed(camera, (zooms or {}).get(i, 1.0)) for i, camera in enumerate(ring))
    way = Way.through([-1.6, -1.6, height[0]], [1.6, 1.6, height[1]], random)
    frames, late = np.arange(rows), late or {}
    exact = np.stack([project(c, way.at(frames + late.get(i, 0.0))) for i, c in enumerate(ring)], axis=1)
    return _seen(ring, way.at(frames), exact, random, missing, outliers, noise)


@dataclass(frozen=True, eq=False)
class Way:
    """A sum of two oscillations along each axis. middle, (3,) m; reach, turns and phase: (2, 3)."""

    middle: Array
    reach: Array
    turns: Array
    phase: Array

    @classmethod
    def through(cls, low: Sequence[float], high: Sequence[float], random: np.random.Generator) -> Way:
        """One that fills a box between two corners, m."""
        low, high = np.array(low), np.array(high)
        reach = np.array([[0.6], [0.4]]) * (high - low) / 2
        turns = random.uniform([[0.004], [0.008]], [[0.008], [0.014]], (2, 3))
        return cls((low + high) / 2, reach, turns, random.uniform(0, 2 * np.pi, (2, 3)))

    def at(self, frame: Array) -> Array:
        """Places at moments that are counted in frames, (N,) -> (N, 3) m."""
        angle = 2 * np.pi * self.turns * np.asarray(frame, float)[:, None, None] + self.phase
        return np.asarray(self.middle + (self.reach * np.sin(angle)).sum(axis=1))


def _seen(
    ring: tuple[Camera, ...],
    points: Array,
    exact: Array,
    random: np.random.Generator,
    missing: float,
    outliers: float,
    noise: float,
) -> MadeRoom:
    """What cameras make of exact pixels, (N, C, 2): noise, reflections, and gaps."""
    pixel = exact + random.normal(0, 1, exact.shape) * noise
    outlier = random.random(pixel.shape[:2]) < outliers
    pixel[outlier] = random.uniform([0, 0], SIZE, (int(outlier.sum()), 2))
    unseen = (random.random(pixel.shape[:2]) < missing) | ((pixel < 0) | (pixel > SIZE)).any(axis=2)
    pixel[unseen] = np.nan
    names = tuple(camera.name for camera in ring)
    sizes = np.tile(SIZE, (len(ring), 1))
    rows = len(points)
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


def wand_of_two(room: MadeRoom, length: float, spread: float = 0.0) -> MadeRoom:
    """The room with a second bulb in any direction from the first; its N rows follow those of the first.

    length: m; spread: m, one sigma of how loose it is.
    """
    random, rows = np.random.default_rng(3), len(room.points)
    along = random.normal(size=room.points.shape)
    reach = length + spread * random.normal(size=(rows, 1))
    ends = np.concatenate(
        [room.points, room.points + reach * along / np.linalg.norm(along, axis=1, keepdims=True)]
    )
    exact = np.stack([project(camera, ends) for camera in room.cameras], axis=1)
    found = _seen(room.cameras, ends, exact, random, 0.0, 0.0, 0.4)
    frame, label = np.tile(np.arange(rows), 2), np.repeat([0, 1], rows)
    return replace(found, sightings=replace(found.sightings, frame=frame, label=label))


def wand_file(room: MadeRoom, path: Path) -> Path:
    """The sightings as lines frame,camera,u,v,point."""
    seen = room.sightings
    lines = [
        f"{frame},{name},{u!r},{v!r},{label}"
        for frame, label, views in zip(
            seen.frame.tolist(), seen.label.tolist(), seen.pixel.tolist(), strict=True
        )
        for name, (u, v) in zip(seen.cameras, views, strict=True)
        if np.isfinite(u)
    ]
    path.write_text("frame,camera,u,v,point\n" + "\n".join(lines))
    return path


def off_by(cameras: Sequence[Camera], true: Sequence[Camera]) -> tuple[Array, Array]:
    """How far centres, mm, and rotations, degrees, are off after the best similarity of the centres."""
    target = np.array([camera.center for camera in true])
    move = similarity(np.array([camera.center for camera in cameras]), target)
    found = [move.camera(camera) for camera in cameras]
    apart = np.linalg.norm([camera.center for camera in found] - target, axis=1)
    traces = np.array([np.trace(c.rotation @ t.rotation.T) for c, t in zip(found, true, strict=True)])
    return 1000 * apart, np.degrees(np.arccos(np.clip((traces - 1) / 2, -1, 1)))


def camera_of(name: str, size: tuple[int, int], given: Mapping[str, Any]) -> Camera:
    """A camera from K, dist, and R and t where they are given."""
    matrix, lens = np.array(given["K"], float), np.array(given["dist"], float).ravel()
    rotation, translation = np.array(given.get("R", np.eye(3))), np.array(given.get("t", np.zeros(3)))
    return Camera(name, "color", size, matrix, lens, rotation, translation.ravel())
