"""The moving spots of the projections: one trails each ball on the floor, the others sway on all screens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.rendering.screen import Screen

TRAILING_RADIUS = 0.085
"""Radius of a spot that trails a ball, m."""
RADII = (0.06, 0.15)
"""Smallest and largest radius of another spot, m."""
RATES = (0.15, 0.55)
"""Slowest and fastest sway of a spot, half turns a second."""
SWAY = (0.62, 0.3)
"""Reach of the two sways of a spot, over half the size of its screen."""
CIRCLING, CIRCLING_RATE = 0.22, 2.1
"""Reach of a trailing spot about the place below its ball, m, and its rate, rad/s."""
CIRCLING_PHASE = np.arange(2) * 1.6
"""Phase of this motion along each axis, rad: nearly a circle."""


@dataclass(frozen=True, eq=False)
class MovingSpots:
    """N spots. rate, phase: (2, N, 2) of two sways along each axis of the screen."""

    target: Array
    """(N,) ball whose colour a spot has."""
    trailing: Array
    """(N,) bool: the spot trails its ball on the first screen, the floor."""
    screen: Array
    """(N,) number of the screen."""
    radius: Array
    """(N,) m."""
    rate: Array
    phase: Array

    @classmethod
    def drawn(cls, each: int, balls: int, screens: Sequence[Screen], rng: np.random.Generator) -> MovingSpots:
        """Spots with random sizes and motions. each: number of spots of a ball; balls: their number."""
        target = np.tile(np.arange(balls), each)
        spots = len(target)
        trailing = np.arange(spots) < balls
        screen = np.where(trailing, 0, np.arange(spots) // max(balls, 1) % max(len(screens), 1))
        radius = np.where(trailing, TRAILING_RADIUS, rng.uniform(*RADII, spots))
        rate = rng.uniform(*RATES, (2, spots, 2)) * rng.choice([-1, 1], (2, spots, 2))
        return cls(target, trailing, screen, radius, rate, rng.uniform(0, 2 * np.pi, (2, spots, 2)))

    def places(self, time: float, balls: Array, screens: Sequence[Screen]) -> Array:
        """Position of every spot on its screen, (N, 2) m along its axes.

        time: s; balls: (T, 3) m, their centres when the trailing spots saw them.
        """
        sway = np.sin(self.rate * time * np.pi + self.phase)
        size = np.array([screen.size for screen in screens])[self.screen]
        where = size / 2 * (1 + SWAY[0] * sway[0] + SWAY[1] * sway[1])
        below = (balls - screens[0].corner) @ screens[0].axes.T
        where[self.trailing] = below + CIRCLING * np.sin(CIRCLING_RATE * time + CIRCLING_PHASE)
        return np.asarray(where)
