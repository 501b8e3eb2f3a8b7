"""Numbered slots, each with a position, a velocity and whether its object is tracked now."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot.messages import Array
from followspot.plain_values import from_plain
from followspot.rotation import rotation_vector

LARGEST = 1e6
"""Largest number (m, m/s, rad) that is sent; larger ones exceed the range of receivers."""


@dataclass(frozen=True)
class Slots:
    """N slots, 1 to N in rows 0 to N - 1; an object that is not tracked now keeps its last values.

    names: (N,), "" for a free slot; known: (N,) bool; position: (N, 3) m, velocity: (N, 3) m/s;
    heading: (N,) rad counter-clockwise from the room's x axis, 0 for objects without one; quaternion: (N, 4)
    as in `followspot.inertial.PosedTracks`, NaN for objects without one.
    """

    names: tuple[str, ...]
    known: Array
    position: Array
    velocity: Array
    heading: Array
    quaternion: Array

    @staticmethod
    def free(count: int) -> Slots:
        """Free slots."""
        zeros, unknown = np.zeros((count, 3)), np.full((count, 4), np.nan)
        return Slots(("",) * count, np.zeros(count, bool), zeros, zeros, np.zeros(count), unknown)

    @staticmethod
    def restored(state: Any, count: int) -> Slots:
        """The first `count` slots of a state that `to_plain` made; those that it lacks are free."""
        old, free = from_plain(Slots, state), Slots.free(count)
        kept = min(count, len(old.names))
        columns = ("known", "position", "velocity", "heading", "quaternion")
        parts = {
            name: np.concatenate([getattr(old, name)[:kept], getattr(free, name)[kept:]]) for name in columns
        }
        return Slots((*old.names[:kept], *free.names[kept:]), **parts)

    @property
    def oriented(self) -> Array:
        """(N,) bool: whether an object has a quaternion."""
        return np.asarray(np.isfinite(self.quaternion).all(axis=1))

    @property
    def rotation(self) -> Array:
        """(N, 3) rotation vectors, rad; by the heading if there is no quaternion."""
        about_up = self.heading[:, None] * np.array([0.0, 0.0, 1.0])
        return np.where(self.oriented[:, None], rotation_vector(self.quaternion), about_up)


def sendable(numbers: Array) -> Array:
    """Rows with numbers that receivers take: (N, K) -> (N,) bool; NaN is none."""
    return np.asarray((np.abs(numbers) <= LARGEST).all(axis=1))
