"""Furniture and wall decoration as boxes, drawn from a seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.actor.parameters import ActorParams

CUPBOARD = (0.45, 1.2, 2.1)
"""Depth, width and height, m."""
FLAT = 0.03
"""Depth of wall decoration, m."""
CORNER = 0.5
"""Distance of furniture from the corners of the room, m."""


@dataclass(frozen=True)
class Box:
    """An upright box.

    kind: its texture; x, y, z: middle of its bottom, m; yaw: heading of its front, rad; size: depth, width
    and height, m; seed: of its texture.
    """

    kind: str
    x: float
    y: float
    z: float
    yaw: float
    size: tuple[float, float, float]
    seed: int

    def axes(self) -> Array:
        """Forward, left and up, (3, 3)."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    def middle(self) -> Array:
        """(3,) m."""
        return np.array([self.x, self.y, self.z + self.size[2] / 2])


HANGING: tuple[tuple[str, float, tuple[float, float]], ...] = (
    ("window", 0.95, (1.6, 1.25)),
    ("poster", 1.15, (0.7, 0.9)),
    ("door", 0.0, (0.95, 2.05)),
    ("board", 1.0, (1.5, 0.9)),
)
"""Wall decoration: kind, height of the lower edge, width and height, m."""
STANDING: tuple[tuple[str, tuple[float, float, float]], ...] = (
    ("books", (0.32, 1.0, 1.9)),
    ("drawers", (0.45, 0.9, 0.85)),
    ("sofa", (0.8, 1.7, 0.75)),
    ("table", (0.6, 1.2, 0.74)),
)
"""Furniture at walls: kind, depth, width and height, m."""


def furniture_of(params: ActorParams) -> tuple[Box, ...]:
    """Two decorations and two pieces of furniture for each wall, and the cupboard if there is one."""
    rng = np.random.default_rng([params.seed, 59])
    found: list[Box] = []
    for wall, yaw in enumerate(np.pi / 2 * np.arange(4) + np.pi):
        along = params.room_size[1 if wall % 2 == 0 else 0] / 2 - CORNER
        away = params.room_size[0 if wall % 2 == 0 else 1] / 2
        for half in (-1, 1):
            kind, z, (width, height) = HANGING[(2 * wall + (half > 0)) % len(HANGING)]
            found.append(_at_wall(rng, kind, yaw, away, along, half, z, (FLAT, width, height)))
        kind_at, size = STANDING[wall]
        found.append(_at_wall(rng, kind_at, yaw, away, along, int(rng.choice([-1, 1])), 0.0, size))
    if params.cupboard is not None:
        x, y = params.cupboard
        toward = float(np.arctan2(-y, -x))
        found.append(Box("cupboard", x, y, 0.0, toward, CUPBOARD, int(rng.integers(1 << 30))))
    return tuple(found)


def _at_wall(
    rng: np.random.Generator,
    kind: str,
    yaw: float,
    away: float,
    along: float,
    half: int,
    z: float,
    size: tuple[float, float, float],
) -> Box:
    """A box whose back touches a wall, somewhere in one half of it."""
    room_for = max(along - size[1] / 2, 0.0)
    aside = half * float(rng.uniform(min(size[1] / 2 + 0.05, room_for), room_for))
    out = away - size[0] / 2
    x = -out * np.cos(yaw) - aside * np.sin(yaw)
    y = -out * np.sin(yaw) + aside * np.cos(yaw)
    return Box(kind, float(x), float(y), z, float(yaw), size, int(rng.integers(1 << 30)))
