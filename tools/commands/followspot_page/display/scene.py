"""The room as the page draws it: cameras as frusta, planes as patches, targets in their own colours."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from followspot.geometry import ray
from followspot.messages import Array
from followspot.room import Camera, Room, Target
from followspot_dashboard.depth_colors import scale_colors

_REACH = 8.0
"""Largest distance of the drawn room from the middle of its cameras, m."""
_MARGIN = 0.3
_RIM = 0.15
"""Share of the seen floor that may lie outside the box on each side."""
_INNER = np.linspace(0.2, 0.8, 5)
"""Places in a picture at which the floor is sampled, as a share of its width or height."""
_AROUND = np.linspace(0.0, 1.0, 12, endpoint=False)
"""The same along a panorama."""
_DIFFERENT = 20
"""Smallest difference of hue between two colours, degrees."""
_ACROSS = 0.99
"""Component of a unit normal along an axis from which on a wall counts as perpendicular to it."""
_SHADES = 9
"""Colours that a scale of depth is drawn with."""
_PALETTE = (205.0, 28.0, 140.0, 275.0, 52.0, 175.0, 330.0, 240.0)
"""Hues of targets without one of their own, degrees, as far apart as possible."""


def scene(room: Room) -> dict[str, Any]:
    """The room in JSON types, m."""
    low, high = bounds(room)
    return {
        "name": room.name,
        "low": low.round(3).tolist(),
        "high": high.round(3).tolist(),
        "cameras": [_camera(camera, low, high) for camera in room.cameras.values()],
        "planes": [{"name": name, "corners": patch(plane, low, high)} for name, plane in room.planes.items()],
        "targets": [
            {"name": target.name, "radius": target.radius, "color": color}
            for target, color in zip(room.targets.values(), colors(list(room.targets.values())), strict=True)
        ],
    }


def bounds(room: Room) -> tuple[Array, Array]:
    """Lowest and highest corner of the drawn box, (3,) m: the cameras and the floor that they see."""
    centers = np.array([camera.center for camera in room.cameras.values()]).reshape(-1, 3)
    if not len(centers):
        return np.array([-2.5, -2.5, 0.0]), np.array([2.5, 2.5, 2.5])
    hits = [_floor_seen(camera) for camera in room.cameras.values()]
    floor = np.vstack([centers * [1, 1, 0], *hits])
    middle = np.append(np.median(centers[:, :2], axis=0), 0.0)
    low = np.maximum(np.quantile(floor, _RIM, axis=0) - _MARGIN, middle - _REACH)
    high = np.minimum(np.quantile(floor, 1 - _RIM, axis=0) + _MARGIN, middle + _REACH)
    low = np.minimum(low, centers.min(0) - _MARGIN)
    high = np.maximum(high, centers.max(0) + _MARGIN)
    for plane in room.planes.values():
        _stop_at(plane, centers.mean(0), low, high)
    low[2] = 0.0
    high[2] = max(2.2, float(high[2]))
    return low, high


def farthest(camera: Camera, low: Array, high: Array) -> float:
    """Depth of the farthest corner of a box in a camera's coordinates, whole metres, at least 1."""
    corners = np.array(list(product(*zip(low, high, strict=True))))
    return max(1.0, math.ceil(float((corners @ camera.rotation[2] + camera.translation[2]).max())))


def _stop_at(plane: Array, inside: Array, low: Array, high: Array) -> None:
    """Limit the box at a wall across an axis; inside: a point on its near side, (3,) m."""
    axis = int(np.abs(plane[:3]).argmax())
    if axis == 2 or abs(plane[axis]) < _ACROSS:
        return
    wall = -plane[3] / plane[axis]
    if inside[axis] > wall:
        low[axis] = max(low[axis], wall)
    else:
        high[axis] = min(high[axis], wall)


def patch(plane: Array, low: Array, high: Array) -> list[list[float]]:
    """The corners, in order, of a plane's intersection with a box; empty if they do not meet."""
    found = []
    box = np.array([low, high])
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        if abs(plane[axis]) < 1e-9:
            continue
        for a, b in product((0, 1), repeat=2):
            point = np.zeros(3)
            point[others] = box[a, others[0]], box[b, others[1]]
            point[axis] = -(plane[3] + plane[others] @ point[others]) / plane[axis]
            if low[axis] - 1e-6 <= point[axis] <= high[axis] + 1e-6:
                found.append(point)
    return _around(np.array(found), plane[:3]) if len(found) > 2 else []


def colors(targets: Sequence[Target]) -> list[str]:
    """A CSS colour for each target: the hue of its template, moved if two would look alike."""
    taken: list[float] = []
    for number, target in enumerate(targets):
        hue = _hue(target)
        if hue is None or not _free(hue, taken):
            hue = next((other for other in _PALETTE if _free(other, taken)), number * 47.0)
        taken.append(hue)
    return [_css(hue) for hue in taken]


def _hue(target: Target) -> float | None:
    """Mean hue of the template, degrees; None if there is none."""
    histograms = list(target.hue_histogram.values())
    if not histograms:
        return None
    weights = np.sum(histograms, axis=0)
    angles = (np.arange(len(weights)) + 0.5) * 2 * math.pi / len(weights)
    if len(weights) == 16 and weights[0] > 0.5 * weights.sum():
        return 2.0  # its bin begins at 0
    return math.degrees(math.atan2(weights @ np.sin(angles), weights @ np.cos(angles))) % 360


def _free(hue: float, taken: Sequence[float]) -> bool:
    """True if a hue, degrees, differs enough from those taken."""
    return all(abs((hue - other + 180) % 360 - 180) >= _DIFFERENT for other in taken)


def _css(hue: float) -> str:
    red, green, blue = colorsys.hls_to_rgb(hue / 360.0, 0.62, 0.95)
    return f"#{round(red * 255):02x}{round(green * 255):02x}{round(blue * 255):02x}"


def _camera(camera: Camera, low: Array, high: Array) -> dict[str, Any]:
    width, height = camera.size
    corners = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]], float)
    rays = ray(camera, corners) if camera.model in ("pinhole", "rational") else np.zeros((0, 3))
    return {
        "name": camera.name,
        "kind": camera.kind,
        "model": camera.model,
        "size": [width, height],
        "center": camera.center.round(4).tolist(),
        "rays": rays.round(4).tolist() if np.isfinite(rays).all() else [],
        "depths": _depths(farthest(camera, low, high)) if camera.kind == "depth" else None,
    }


def _depths(reach: float) -> dict[str, Any]:
    """The scale of a depth camera's picture; reach: depth of its last colour, m."""
    return {"farthest": reach, "colors": scale_colors(_SHADES)}


def _floor_seen(camera: Camera) -> Array:
    """Intersection of the picture's inner part with the floor, (N, 3) m."""
    width, height = camera.size
    across = _AROUND if camera.model == "cylinder" else _INNER
    grid = np.array(list(product(across * width, _INNER * height)))
    rays = ray(camera, grid)
    down = np.isfinite(rays).all(1) & (rays[:, 2] < -0.1)
    steps = -camera.center[2] / rays[down, 2]
    return np.asarray(camera.center + rays[down] * steps[:, None])


def _around(points: Array, normal: Array) -> list[list[float]]:
    """Points of a convex patch in the order of their angle around its middle, each once."""
    points = np.unique(points.round(4), axis=0)
    offsets = points - points.mean(0)
    u = offsets[np.linalg.norm(offsets, axis=1).argmax()]
    v = np.cross(normal, u)
    order = np.argsort(np.arctan2(offsets @ v, offsets @ u))
    corners: list[list[float]] = points[order].tolist()
    return corners
