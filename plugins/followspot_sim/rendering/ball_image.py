"""The picture of glowing balls, exact to a small part of a pixel; all balls of a picture at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array
from followspot_sim.rendering.camera_rays import REACH, CameraRays
from followspot_sim.rendering.ray_casting import dot
from followspot_sim.sensor import DISPLAYED

DEFOCUS = 1.7
"""Width of the soft edge of a ball, px."""
HALO, GLOW = 0.2, 2.0
"""Brightness of the glow at the edge of the ball, over that of the ball, and radii at which it ends."""


@dataclass(frozen=True, eq=False)
class Stamps:
    """Balls in square windows of one picture, from far to near.

    ball: (B,) their numbers; corner: (B, 2) column and row where its window begins; cover: (B, S, S)
    uint8, share of each pixel that the ball fills and nothing hides, in 1/255; square: (B, S, S)
    squared distance of the line of sight from the centre of the ball, in radii; distance: (B,) m;
    shown: (B,) share of the ball in the picture that nothing hides.
    """

    ball: Array
    corner: Array
    cover: Array
    square: Array
    distance: Array
    shown: Array


def stamps(view: CameraRays, pixel: Array, balls: Array, radii: Array) -> Stamps:
    """The balls as the camera would see them alone; those outside the picture or not shown are left out.

    pixel: (T, 2) px, projected centres; balls: (T, 3) m; radii: (T,) m. A ray meets a ball where it
    passes the centre at less than the radius, so the ellipse of the sphere and the lens come out right.
    """
    away = balls - view.camera.center
    distance = np.sqrt(dot(away, away))
    size = np.array(view.camera.size)
    with np.errstate(invalid="ignore"):
        nearest = np.minimum(np.maximum(np.rint(pixel).astype(int), 0), size - 1)
        pitch = view.pitch[nearest[:, 1] * size[0] + nearest[:, 0]]
        reach = REACH[view.camera.kind] * radii / (distance * pitch) + 2.0
        seen = ((pixel > -reach[:, None]) & (pixel < size + reach[:, None])).all(axis=1)
    ball = np.flatnonzero(seen)
    ball = ball[np.argsort(-distance[ball], kind="stable")]
    distance, radius = distance[ball], radii[ball]
    side = min(2 * math.ceil(reach[ball].max(initial=1.0)) + 1, int(size.min()))
    corner = np.rint(pixel[ball]).astype(int) - side // 2
    corner = np.minimum(np.maximum(corner, 0), size - side)
    square = _square(view, corner, side, away[ball])
    square /= np.square(radius).astype(np.float32)[:, None, None]
    hard = 255 * radius / (DEFOCUS * pitch[ball] * distance)
    soft = (1.0 - np.sqrt(square)) * hard.astype(np.float32)[:, None, None]
    cover = np.minimum(np.maximum(128.0 + soft, 0), 255).astype(np.uint8)
    return Stamps(ball, corner, cover, square, distance, np.ones(len(ball)))


def _square(view: CameraRays, corner: Array, side: int, away: Array) -> Array:
    """Squared distance of the pixels' lines of sight from the balls' centres, (B, S, S) float32 m^2.

    In float32 it is exact to 3e-6 m^2, which moves the edge of a ball by 0.02 mm.
    """
    width, span = view.camera.size[0], np.arange(side)
    window = width * span[:, None] + span
    rays = view.rays.take((corner[:, 1] * width + corner[:, 0])[:, None, None] + window, axis=1)
    x, y, z = away.astype(np.float32).T[:, :, None, None]
    along = rays[0] * x + rays[1] * y + rays[2] * z
    return np.asarray(np.maximum(x * x + y * y + z * z - along * along, 0))


def color_light(seen: Stamps, color: Array) -> Array:
    """The light of glowing balls: their colour, a glow around it, and an overexposed core.

    The core turns white; the glow is proportional to the visible share of the ball.
    color: (T, 3) linear BGR. Returns (B, S, S, 3) uint8, what is added where the ball is.
    """
    if not seen.cover.size:
        return np.zeros((*seen.cover.shape, 3), np.uint8)
    square, cover = seen.square, seen.cover * np.float32(1 / 255)
    core = 0.45 * np.exp(square * np.float32(-1 / 0.12))
    tail = np.maximum(GLOW * GLOW - square, 0) / (GLOW * GLOW - 1)
    halo = tail * tail * (HALO * seen.shown).astype(np.float32)[:, None, None]
    own = (1 - 0.12 * np.minimum(square, 1) - core - halo) * cover + halo
    white = 255 * core * cover + 0.5
    light = own[..., None] * color[seen.ball][:, None, None] + white[..., None]
    shown = cv2.LUT(np.minimum(light, 255).astype(np.uint8).reshape(-1, 3), DISPLAYED)
    return np.asarray(shown.reshape(light.shape))


def infrared_light(seen: Stamps, brightness: Array) -> Array:
    """Light of the reflecting patches: rings, which have no preferred side, so the centre stays.

    brightness: (B,) grey levels. Returns (B, S, S) uint8.
    """
    level = (brightness / 255).astype(np.float32)[:, None, None]
    light = level * (0.9 + 0.1 * np.cos(7.0 * seen.square)) * seen.cover + 0.5
    return np.asarray(np.minimum(light, 255).astype(np.uint8))


def compose(picture: Array, seen: Stamps, light: Array) -> None:
    """Put the balls over the picture, (H, W) or (H, W, 3) uint8; light: (B, S, S[, 3]) uint8."""
    kept = 255 - seen.cover
    if light.ndim > kept.ndim:
        kept = np.repeat(kept[..., None], light.shape[-1], axis=-1)
    side = kept.shape[1]
    for ball, (column, row) in enumerate(seen.corner.tolist()):
        window = picture[row : row + side, column : column + side]
        cv2.multiply(window, kept[ball], dst=window, scale=1 / 255)
        cv2.add(window, light[ball], dst=window)
