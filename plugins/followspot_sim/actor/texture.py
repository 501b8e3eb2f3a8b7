"""Textures of the simulated room: the colour of points on walls, floor, furniture.

Every texture takes the number of the face (0 front, 1 other sides, 2 top or bottom), the place on it
(u to the right, v upwards, m from the lower left corner), its width and height (m), and random numbers.
Colours are BGR, 0 to 255.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array


@dataclass(frozen=True, eq=False)
class Spots:
    """Points on a surface: face (N,), u and v (N,) m; width, height: of the surface, m."""

    face: Array
    u: Array
    v: Array
    width: float
    height: float


def cloud(rng: np.random.Generator, u: Array, v: Array, grain: float) -> Array:
    """Smooth random numbers around 0 with features of `grain` m, (N,)."""
    tile = rng.normal(0.0, 1.0, (64, 64)).astype(np.float32)
    x, y = (np.mod(w / grain, 63).astype(np.float32) for w in (u, v))
    rows = -(-len(u) // 1024)  # cv2.remap takes pictures of fewer than 32768 columns
    x, y = (np.resize(w, (rows, 1024)) for w in (x, y))
    return np.asarray(cv2.remap(tile, x, y, cv2.INTER_LINEAR).ravel()[: len(u)])


def _flat(at: Spots, color: Array | tuple[float, ...]) -> Array:
    return np.tile(np.array(color, float), (len(at.u), 1))


def wall(at: Spots, rng: np.random.Generator) -> Array:
    """Paint, wallpaper with stripes, or tiles; a skirting board below."""
    base = rng.uniform(120, 185) * np.array([1.0, 1.0, 1.0]) * rng.uniform(0.85, 1.1, 3)
    color = _flat(at, base)
    pattern = rng.integers(4)
    if pattern == 1:
        color[np.mod(at.u, 0.24) < 0.12] *= 0.86
    elif pattern == 2:
        color[(np.mod(at.u, 0.5) < 0.012) | (np.mod(at.v, 0.5) < 0.012)] *= 0.75
    elif pattern == 3:
        row = np.floor(at.v / 0.09)
        color *= 0.6
        color[(np.mod(at.u + 0.12 * np.mod(row, 2), 0.24) < 0.014) | (np.mod(at.v, 0.09) < 0.012)] *= 1.5
    color *= 1 + 0.03 * cloud(rng, at.u, at.v, 0.3)[:, None]
    color[at.v < 0.1] = (190, 195, 198)
    return color


def floor(at: Spots, rng: np.random.Generator) -> Array:
    """Chequered tiles, planks or carpet."""
    base = rng.uniform(85, 130) * rng.uniform(0.85, 1.1, 3)
    color = _flat(at, base)
    pattern = rng.integers(3)
    if pattern == 0:
        odd = np.mod(np.floor(at.u / 0.4) + np.floor(at.v / 0.4), 2) > 0
        color[odd] *= 1.22
    elif pattern == 1:
        plank = np.floor(at.u / 0.14)
        color *= (1 + 0.12 * np.sin(plank * 12.9898) * np.sin(plank * 78.2))[:, None]
        color[np.mod(at.u, 0.14) < 0.008] *= 0.7
    else:
        color *= 1 + 0.10 * cloud(rng, at.u, at.v, 0.03)[:, None]
    return np.asarray(color * (1 + 0.05 * cloud(rng, at.u, at.v, 0.12)[:, None]))


def ceiling(at: Spots, rng: np.random.Generator) -> Array:
    """White paint and a bright panel in the middle."""
    color = _flat(at, (168, 172, 172))
    lamp = (np.abs(at.u - at.width / 2) < 0.6) & (np.abs(at.v - at.height / 2) < 0.35)
    color[lamp] = 400.0
    return color


def _window(at: Spots, rng: np.random.Generator) -> Array:
    """Trees before a bright sky, in a white frame."""
    shape = cloud(rng, at.u, at.v, 0.16) + 2.2 * (0.45 * at.height - at.v)
    color = np.where((shape > 0)[:, None], (70, 150, 90), (262, 252, 240)).astype(float)
    color *= 1 + 0.12 * cloud(rng, at.u, at.v, 0.05)[:, None]
    edge = np.minimum.reduce([at.u, at.width - at.u, at.v, at.height - at.v])
    color[(edge < 0.06) | (np.abs(at.u - at.width / 2) < 0.025)] = (205, 208, 208)
    return color


def _poster(at: Spots, rng: np.random.Generator) -> Array:
    """A landscape in strong colours, in a dark frame."""
    height = at.v / at.height + 0.12 * cloud(rng, at.u, np.zeros_like(at.v), 0.12)
    bands = np.sort(rng.uniform(0.15, 0.85, 4))
    color = rng.uniform(15, 235, (5, 3))[np.searchsorted(bands, height)]
    color *= 1 + 0.15 * cloud(rng, at.u, at.v, 0.05)[:, None]
    edge = np.minimum.reduce([at.u, at.width - at.u, at.v, at.height - at.v])
    color[edge < 0.025] = (40, 45, 50)
    return np.asarray(color)


def _board(at: Spots, rng: np.random.Generator) -> Array:
    """A white board with scribbles."""
    color = _flat(at, (215, 216, 214))
    written = (np.mod(at.v, 0.12) < 0.02) & (cloud(rng, at.u, np.floor(at.v / 0.12), 0.05) > 0.3)
    color[written] = (90, 70, 60)
    edge = np.minimum.reduce([at.u, at.width - at.u, at.v, at.height - at.v])
    color[edge < 0.02] = (120, 122, 125)
    return color


def _wood(at: Spots, rng: np.random.Generator, base: tuple[float, ...]) -> Array:
    veins = cloud(rng, 9 * at.u, at.v, 0.35)
    return np.asarray(_flat(at, base) * (1 + 0.07 * veins[:, None]))


def _door(at: Spots, rng: np.random.Generator) -> Array:
    """Wood with two panels, a frame and a handle."""
    color = _wood(at, rng, (95, 130, 168))
    inner = (np.abs(at.u - at.width / 2) < 0.3) & (np.abs(np.mod(at.v, 1.0) - 0.5) < 0.38)
    color[inner] *= 0.86
    color[(np.minimum(at.u, at.width - at.u) < 0.07) | (at.height - at.v < 0.07)] = (190, 196, 200)
    color[(np.abs(at.u - 0.16) < 0.05) & (np.abs(at.v - 1.05) < 0.02)] = (60, 60, 62)
    return color


def _books(at: Spots, rng: np.random.Generator) -> Array:
    """Shelves full of books in front, wood elsewhere."""
    color = _wood(at, rng, (70, 100, 135))
    shelf = np.floor(at.v / 0.36)
    spine = np.floor(at.u / 0.045) + 57 * shelf
    palette = rng.uniform(20, 190, (97, 3)) * rng.uniform(0.4, 1.0, (97, 1))
    tall = 0.20 + 0.1 * np.abs(np.sin(spine * 7.13))
    inside = (at.u > 0.04) & (at.u < at.width - 0.04) & (at.v > 0.06) & (at.v < at.height - 0.04)
    within = np.mod(at.v, 0.36)
    behind = (at.face == 0) & inside & (within > 0.03)
    color[behind] = (28, 34, 42)
    book = behind & (within < tall) & (np.mod(spine, 11) > 0.5)
    color[book] = palette[np.mod(spine[book], 97).astype(int)]
    return color


def _drawers(at: Spots, rng: np.random.Generator) -> Array:
    """Painted drawers with handles."""
    color = _flat(at, rng.uniform(90, 190, 3))
    within = np.mod(at.v, at.height / 3)
    front = at.face == 0
    color[front & (within < 0.018)] *= 0.5
    color[front & (np.abs(within - 0.15) < 0.014) & (np.abs(at.u - at.width / 2) < 0.09)] = (70, 72, 75)
    return color


def _cupboard(at: Spots, rng: np.random.Generator) -> Array:
    """Two tall doors of wood."""
    color = _wood(at, rng, (80, 112, 150))
    front = at.face == 0
    color[front & (np.abs(at.u - at.width / 2) < 0.008)] *= 0.4
    color[front & (np.abs(np.abs(at.u - at.width / 2) - 0.06) < 0.012) & (np.abs(at.v - 1.0) < 0.1)] = 60.0
    return color


def _sofa(at: Spots, rng: np.random.Generator) -> Array:
    """Cloth with seams between the cushions."""
    color = _flat(at, rng.uniform(50, 150, 3))
    color *= 1 + 0.05 * cloud(rng, at.u, at.v, 0.03)[:, None]
    color[(np.mod(at.u, at.width / 3) < 0.015) | ((at.face == 0) & (np.abs(at.v - 0.42) < 0.012))] *= 0.6
    return color


def _table(at: Spots, rng: np.random.Generator) -> Array:
    """A table with closed sides and something bright on top."""
    color = _wood(at, rng, (120, 160, 190))
    color[(at.face < 2) & (at.v < at.height - 0.06)] *= 0.35
    return color


TEXTURES: dict[str, Callable[[Spots, np.random.Generator], Array]] = {
    "window": _window,
    "poster": _poster,
    "door": _door,
    "board": _board,
    "books": _books,
    "drawers": _drawers,
    "cupboard": _cupboard,
    "sofa": _sofa,
    "table": _table,
}
"""By the kind of a box."""
