"""Lengths of a room that can hardly be meant in metres, as if millimetres were written."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from followspot.errors import Mistake, Place
from followspot.messages import Array
from followspot.room import Room
from followspot.yaml.node import Node, child

SMALLEST_RADIUS, LARGEST_RADIUS = 0.0005, 3.0
"""Smallest and largest radius of a target, m."""
_CLOSEST, _FARTHEST = 0.001, 500.0
"""Smallest and largest distance between the cameras that stand farthest apart, m."""
_WIDE = 1.0
"""Cameras at least this far apart, m, are taken to surround the targets."""
_REMEDY = "lengths are metres; divide by 1000 what is in mm"
_CLOSE_REMEDY = "lengths are metres; multiply by 1000 what is in km"


def implausible_lengths(room: Room, node: Node | None) -> Iterator[Mistake]:
    """A mistake for each target, pair of cameras and plane whose lengths no room has, at its place.

    node: of the room file, None if there is none.
    """
    centers = np.array([camera.center for camera in room.cameras.values()]).reshape(-1, 3)
    one, other, apart = _farthest(centers)
    for target in room.targets.values():
        at = child(child(child(node, "targets"), target.name), "radius")
        if not SMALLEST_RADIUS <= target.radius <= LARGEST_RADIUS:
            text = f"target {target.name} has a radius of {target.radius:g} m"
            yield Mistake(_place(at), text, "a radius is in metres: a ball of 76.2 mm has 0.0762")
        elif apart >= _WIDE and target.radius > apart / 2:
            text = f"target {target.name} has a radius of {target.radius:g} m, but no cameras are more than"
            yield Mistake(_place(at), f"{text} {apart:g} m apart", "a radius is in metres, half the diameter")
    if apart > _FARTHEST or 0 < apart < _CLOSEST:
        names = list(room.cameras)
        at = child(child(child(node, "cameras"), names[other]), "translation")
        text = f"cameras {names[one]} and {names[other]}, farthest apart, have a distance of {apart:g} m"
        yield Mistake(_place(at), text, _REMEDY if apart > _FARTHEST else _CLOSE_REMEDY)
    for name, plane in room.planes.items():
        away = np.abs(centers @ plane[:3] + plane[3])
        if len(away) and away.min() > _FARTHEST:
            text = f"plane {name} is {away.min():g} m away from the nearest camera"
            yield Mistake(_place(child(child(node, "planes"), name)), text, _REMEDY)


def _farthest(centers: Array) -> tuple[int, int, float]:
    """The two of these points (N, 3) that are farthest apart, and their distance, m."""
    if len(centers) < 2:
        return 0, 0, 0.0
    apart = np.linalg.norm(centers[:, None] - centers, axis=2)
    one, other = divmod(int(apart.argmax()), len(centers))
    return one, other, float(apart[one, other])


def _place(node: Node | None) -> Place | None:
    return None if node is None else node.place
