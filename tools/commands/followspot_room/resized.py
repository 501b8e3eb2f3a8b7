"""Targets of a room whose cameras have pictures of another size than those that they were learnt from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from followspot import Camera, Target


def resized(target: Target, before: Mapping[str, Camera], after: Mapping[str, Camera]) -> Target:
    """The target with the areas that cameras see in their new pictures. before, after: by their names."""
    areas = {}
    for name, (smallest, largest) in target.area.items():
        ratio = _larger(before[name], after[name]) if name in before and name in after else 1.0
        areas[name] = (smallest * ratio, largest * ratio)
    return replace(target, area=areas)


def _larger(before: Camera, after: Camera) -> float:
    """How many times as large the area of the same object is after as before, in the picture's middle."""
    focal = (camera.matrix[0, 0] * camera.matrix[1, 1] for camera in (after, before))
    return round(float(next(focal) / next(focal)), 9)  # 1 for pictures of one size, whatever was rounded
