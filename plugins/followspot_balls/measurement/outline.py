"""The expected area of a whole target's blob in each camera."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.room import Room


def unit_outline(room: Room) -> Array:
    """Area of the blob of a whole ball of unit radius at unit distance in each camera: (C,) px."""
    focal = np.array([c.matrix[0, 0] for c in room.cameras.values()])
    return np.asarray(np.pi * np.square(focal) * bright_part(room, focal))


def bright_part(room: Room, focal: Array) -> Array:
    """Share of a whole ball's outline that its blob fills in each camera: (C,), 1 without templates.

    Reflective patches are dim towards the rim, so an infrared blob may show less of a ball than a
    colour blob. The templates give the area of whole balls, for cameras at similar distances.
    """
    sizes = np.full(len(focal), np.nan)
    for number, name in enumerate(room.cameras):
        learnt = [np.sqrt(t.area[name][0] * t.area[name][1]) for t in room.targets.values() if name in t.area]
        if learnt:
            sizes[number] = np.median(learnt) / focal[number] ** 2
    color = sizes[[c.kind == "color" for c in room.cameras.values()]]
    known = color[color > 0]
    share = sizes / np.median(known) if len(known) else np.ones(len(sizes))
    return np.where(share > 0, share, 1.0)
