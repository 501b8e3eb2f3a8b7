"""One round of the performance: stations of people, motions of hands and balls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from followspot import Array

ROUND, WALK, SWITCH = 3.0, 1.5, 2.25
"""Length of a round, end of the walk, and the moment at which a ball changes hands, s."""
FLIGHT = 0.65
"""Duration of a throw, s."""
ROLL = (0.3, 2.8)
"""When a rolling ball starts and comes to rest within its round, s."""
BALL_FROM_HAND = np.array([0.11, 0.0, 0.02])
BAG = np.array([-0.05, -0.32, 0.85])
MEETING = np.array([0.42, 0.0, 1.12])
"""In the frame of a person (forward, left, up; m): ball from hand, bag, where hands meet."""


@dataclass(frozen=True)
class Place:
    """Place of a resting ball."""

    kind: Literal["hand", "bag", "floor"]
    person: int = -1
    hand: int = -1
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Move:
    """One ball in one round: at `before` until `leave`, at `after` from `arrive`, between them under way."""

    before: Place
    after: Place
    leave: float = SWITCH
    arrive: float = SWITCH


@dataclass(frozen=True, eq=False)
class Round:
    """One round of the performance.

    start, end: (P, 3) station of each person, x and y in m and heading in rad; reach: (P, 2, 3) m,
    the point that a hand goes to and comes back from, NaN for a hand that stays; bow: (P,) whether
    the person bends down for it; held: (2, P, 2) index in `holding.HOLDS` of each hand at start and end.
    """

    start: Array
    end: Array
    reach: Array
    bow: Array
    moves: tuple[Move, ...]
    held: Array

    def acting(self) -> Array:
        """Which people pass, throw, fetch or stow a ball in this round, (P,) bool."""
        busy = np.zeros(len(self.start), bool)
        for move in self.moves:
            for place in (move.before, move.after):
                if place.kind != "floor" and move.before != move.after:
                    busy[place.person] = True
        return busy


def opening(people: int, balls: int, rest_height: Array) -> Round:
    """The round before the first: people stand in a circle with the balls in their hands.

    rest_height: (T,) height of each ball's centre when it lies on the floor, m. Balls that find no
    hand lie on the floor.
    """
    angle = 2 * np.pi * np.arange(people) / max(people, 1) + 0.4
    stations = np.column_stack([1.1 * np.cos(angle), 1.1 * np.sin(angle), angle + np.pi])
    places = []
    for ball in range(balls):
        if ball < 2 * people:
            places.append(Place("hand", ball % people, ball // people))
        else:
            x, y = -1.0 + 0.7 * (ball % 4), -0.8 + 0.8 * (ball // 4)
            places.append(Place("floor", xyz=(x, y, float(rest_height[ball]))))
    still = np.full((people, 2, 3), np.nan)
    held = np.zeros((2, people, 2), int)
    return Round(stations, stations, still, np.zeros(people), tuple(Move(p, p) for p in places), held)


def in_room(station: Array, local: Array) -> Array:
    """A point in the frame of a person at `station` (x, y, heading), as a point in the room; m."""
    c, s = np.cos(station[2]), np.sin(station[2])
    return np.array(
        [station[0] + c * local[0] - s * local[1], station[1] + s * local[0] + c * local[1], local[2]]
    )


def turned(heading: float, local: Array) -> Array:
    """A vector in the frame of a person of this heading (rad), along the room's axes; m."""
    return in_room(np.array([0.0, 0.0, heading]), local)


def smoothstep(x: Array | float) -> Array:
    """0 before 0, 1 after 1, at rest at both ends."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x * x * (3 - 2 * x))
