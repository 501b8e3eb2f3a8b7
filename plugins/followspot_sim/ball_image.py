"""The picture of glowing balls, exact to a small part of a pixel; all balls of a picture at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.sight import approach, blocked

DEFOCUS = 1.7
"""Width of the soft edge of a ball, px."""
HALO = 0.16
"""Brightness of the glow at the edge of the ball, over that of the ball."""


@dataclass(frozen=True, eq=False)
class View:
    """A camera's eye.

    center: (3,) m; rays: (3, H * W) float32, unit vectors; size: width and height, px; focal:
    length in px; margin: how many pixels around a ball are drawn.
    """

    center: Array
    rays: Array
    size: tuple[int, int]
    focal: float
    margin: int


@dataclass(frozen=True, eq=False)
class Stamps:
    """Balls in square windows of the picture, from far to near.

    ball: (B,) number of the ball; corner: (B, 2) row and column where its window begins; cover:
    (B, S, S) share of each pixel that the ball fills and nothing hides; halo: (B, S, S) share of its
    light that its glow adds; facing: (3, B, S, S) where on the ball the pixel looks, across the line
    of sight, in radii; distance: (B,) m.
    """

    ball: Array
    corner: Array
    cover: Array
    halo: Array
    facing: Array
    distance: Array


def stamps(view: View, pixel: Array, balls: Array, radii: Array, limbs: Array, thick: Array) -> Stamps:
    """The balls as the camera sees them; those outside the picture or not shown are left out.

    pixel: (T, 2) px, projected centres; balls: (T, 3) m; radii: (T,) m; limbs: (K, 2, 3) m and
    thick: (K,) m may hide them. A ray meets a ball where it passes the centre at less than the
    radius; the edge of the disc is that distance in units of its own change per pixel, so the
    ellipse of the sphere and the lens come out right.
    """
    away = balls - view.center
    distance = np.sqrt(np.square(away).sum(axis=1))
    reach = view.focal * radii / distance + view.margin
    width, height = view.size
    with np.errstate(invalid="ignore"):
        seen = np.all((pixel > -reach[:, None]) & (pixel < [width, height] + reach[:, None]), axis=1)
    ball = np.flatnonzero(seen)[np.argsort(-distance[seen])]
    away, distance = away[ball].astype(np.float32), distance[ball].astype(np.float32)
    radius = radii[ball].astype(np.float32)[:, None, None]
    side = min(2 * int(np.ceil(reach[ball].max(initial=1.0))) + 1, width, height)
    corner = np.round(pixel[ball])[:, ::-1] - side // 2
    corner = np.clip(corner, 0, [height - side, width - side]).astype(int)
    span = np.arange(side)
    rows, columns = corner[:, 0, None, None] + span[:, None], corner[:, 1, None, None] + span
    rays = view.rays.take(rows * width + columns, axis=1)
    along = np.einsum("ibhw,bi->bhw", rays, away)
    across = rays * along - away.T[:, :, None, None]
    miss = np.sqrt(np.einsum("ibhw,ibhw->bhw", across, across))
    cover = np.minimum(np.maximum(0.5 + (radius - miss) / (DEFOCUS * _pitch(miss)), 0), 1)
    halo = HALO * np.exp(-1.6 * np.maximum(miss / radius - 1.0, 0.0)) * (1.0 - cover)
    if len(limbs) and len(ball):
        free = cover.sum(axis=(1, 2))
        surface = along - np.sqrt(np.maximum(radius * radius - miss * miss, 0))
        nearness, _ = approach(view.center, away.T / distance, limbs)
        near = np.any(nearness < thick[:, None] + 1.3 * radius[:, 0, 0], axis=1)
        _hide(cover, view, rays, surface, distance, limbs[near], thick[near])
        halo *= (cover.sum(axis=(1, 2)) / np.maximum(free, 1e-9))[:, None, None]
    return Stamps(ball, corner, cover, halo, across / radius, distance)


def _hide(
    cover: Array, view: View, rays: Array, surface: Array, distance: Array, limbs: Array, thick: Array
) -> None:
    """Take from `cover` what limbs hide; only pixels that a ball fills are looked at."""
    filled = np.flatnonzero(cover)
    soft = (distance / view.focal).repeat(cover[0].size).take(filled)
    rays = rays.reshape(3, -1).take(filled, axis=1)
    hidden = blocked(view.center, rays, surface.take(filled), limbs, thick, soft)
    cover.put(filled, cover.take(filled) * (1 - hidden))


def _pitch(miss: Array) -> Array:
    """Change per pixel of a distance, (B, S, S)."""
    down, right = np.gradient(miss, axis=(1, 2))
    return np.asarray(np.sqrt(down * down + right * right) + 1e-9)


def color_light(color: Array, facing: Array) -> Array:
    """Light of glowing balls: their colour, and a core too bright for the sensor, which turns white.

    color: (B, 3) linear BGR; facing: (3, B, S, S) in radii. Returns (B, S, S, 3).
    """
    square = np.einsum("ibhw,ibhw->bhw", facing, facing)[..., None]
    base = color[:, None, None, :]
    core = 0.45 * np.exp(-square / 0.12)
    return np.asarray(base * (1.0 - 0.12 * np.minimum(square, 1.0)) + core * (255.0 - base))


def infrared_light(brightness: Array, facing: Array) -> Array:
    """Light of the reflecting patches, (B, S, S, 1): a pattern without a preferred side, so the centre stays.

    brightness: (B,) grey levels; facing: (3, B, S, S) in radii.
    """
    seams = np.cos(5.0 * facing).prod(axis=0)
    return np.asarray(brightness[:, None, None] * (0.8 + 0.2 * seams))[..., None]
