"""The picture of a glowing ball, exact to a small part of a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_sim.sight import approach, blocked

MARGIN = 6
"""The glow reaches this many pixels beyond the ball."""
HALO = 0.16
"""Brightness of the glow at the edge of the ball, over that of the ball."""


@dataclass(frozen=True, eq=False)
class View:
    """A camera's eye: centre (3,) m, rays (H, W, 3) unit vectors, focal length in px."""

    center: Array
    rays: Array
    focal: float


@dataclass(frozen=True, eq=False)
class Patch:
    """A ball in its window of the picture.

    window: rows and columns; cover: (h, w) share of each pixel that the ball fills and nothing
    hides; halo: (h, w) share of its light that its glow adds; facing: (h, w, 3) where on the ball
    the pixel looks, across the line of sight, in radii.
    """

    window: tuple[slice, slice]
    cover: Array
    halo: Array
    facing: Array


def patch(view: View, pixel: Array, ball: Array, radius: float, limbs: Array, thick: Array) -> Patch | None:
    """The ball as the camera sees it; None where it is outside the picture.

    pixel: (2,) px, its projected centre; ball: (3,) m; limbs: (K, 2, 3) m and thick: (K,) m may hide it.
    A ray meets the ball where it passes the centre at less than the radius; the edge of the disc is
    that distance in units of its own change per pixel, so the ellipse and the lens come out right.
    """
    away = ball - view.center
    distance = float(np.linalg.norm(away))
    window = _window(pixel, view.focal * radius / distance, view.rays.shape)
    if window is None:
        return None
    rays = view.rays[window]
    along = rays @ away
    across = rays * along[..., None] - away
    miss = np.sqrt(np.einsum("hwi,hwi->hw", across, across))
    down, right = np.gradient(miss)
    pitch = np.sqrt(down * down + right * right) + 1e-9
    cover = np.clip(0.5 + (radius - miss) / pitch, 0.0, 1.0)
    halo = HALO * np.exp(-1.6 * np.maximum(miss / radius - 1.0, 0.0)) * (1.0 - cover)
    near = approach(view.center, away[None] / distance, limbs)[0][0] < thick + 3 * radius
    if near.any():
        surface = along - np.sqrt(np.maximum(radius**2 - miss**2, 0.0))
        soft = distance / view.focal
        hidden = blocked(
            view.center, rays.reshape(-1, 3), surface.ravel(), limbs[near], thick[near], soft
        ).reshape(miss.shape)
        seen = cover * (1.0 - hidden)
        halo *= seen.sum() / max(cover.sum(), 1e-9) * (1.0 - hidden)
        cover = seen
    return Patch(window, cover, halo, across / radius)


def _window(pixel: Array, radius: float, shape: tuple[int, ...]) -> tuple[slice, slice] | None:
    """Rows and columns around a disc and its glow; None where fewer than two remain in the picture."""
    reach = radius + MARGIN
    if not np.isfinite(pixel).all():
        return None
    low = np.maximum(np.floor(pixel - reach), 0).astype(int)
    high = np.minimum(np.ceil(pixel + reach) + 1, [shape[1], shape[0]]).astype(int)
    if (high - low < 2).any():
        return None
    return slice(int(low[1]), int(high[1])), slice(int(low[0]), int(high[0]))


def color_light(color: Array, facing: Array) -> Array:
    """Light of a glowing ball: its colour, and a core that is too bright for the sensor and turns white.

    color: (3,) linear BGR; facing: (h, w, 3) in radii. Returns (h, w, 3).
    """
    square = np.einsum("hwi,hwi->hw", facing, facing)[..., None]
    core = 0.45 * np.exp(-square / 0.12)
    return np.asarray(color * (1.0 - 0.12 * square.clip(0, 1)) + core * (255.0 - color))


def infrared_light(brightness: float, facing: Array) -> Array:
    """Light of the reflecting patches, (h, w): a pattern without a preferred side, so the centre stays."""
    seams = np.cos(5.0 * facing).prod(axis=-1)
    return np.asarray(brightness * (0.8 + 0.2 * seams))
