"""Boxes of people and false ones in four cameras, for tests."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from tests.plugins.persons.crowded import corner_room

from followspot import Array
from followspot.geometry import project
from followspot.messages import Header, stamped
from followspot.people import Boxes

ROOM = corner_room()
SECOND = 10**9
SIZE = np.array([1280, 960])


def clutter(count: int, rng: np.random.Generator) -> Array:
    """Boxes (N, 4) px anywhere in a picture."""
    middle, half = rng.uniform([0, 0], SIZE, (count, 2)), rng.uniform([15, 25], [100, 180], (count, 2))
    return np.hstack([middle - half, middle + half]).clip(0, np.tile(SIZE - 1, 2))


def person(xy: Sequence[float]) -> Array:
    """Points (P, 3) m on a person who stands at xy."""
    up, angle = (part.ravel() for part in np.meshgrid(np.linspace(0.05, 1.7, 12), np.linspace(0, 6, 8)))
    return np.column_stack([xy[0] + 0.22 * np.cos(angle), xy[1] + 0.2 * np.sin(angle), up])


def sent(people: Sequence[Array], false: int, time: float, rng: np.random.Generator) -> tuple[Boxes, ...]:
    """Boxes about people's points, and false ones, of each camera."""
    messages = []
    for camera in ROOM.cameras.values():
        pixels = [project(camera, one) for one in people]
        own = np.array([[*one.min(axis=0), *one.max(axis=0)] for one in pixels]).reshape(-1, 4)
        own += rng.normal(0, 4.0, own.shape)
        box = np.vstack([own, clutter(false, rng)])
        none, score = np.zeros((len(box), 0)), np.append(np.ones(len(own)), np.full(false, 0.5))
        header = Header("boxes", 0, round(time * SECOND))
        messages.append(stamped(Boxes(camera.name, box, score, none, none), header))
    return tuple(messages)
