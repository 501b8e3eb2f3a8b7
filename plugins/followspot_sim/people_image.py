"""Limbs as convex outlines in the distorted picture, drawn from far to near."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array, Camera
from followspot.geometry import project

FAN = np.linspace(-np.pi / 2, np.pi / 2, 7)
"""Directions of the round end of a limb, rad from its axis."""
SUBPIXEL = 4
"""Binary digits after the point in coordinates that are handed to OpenCV."""


def outlines(camera: Camera, limbs: Array, radius: Array) -> tuple[Array, Array, Array]:
    """Outlines of limbs in the picture.

    limbs: (K, 2, 3) m; radius: (K,) m. Returns polygons (K, 14, 2) px in OpenCV's fixed point,
    their scale (K,) px/m, and the order from far to near (those in the picture only).
    """
    ends = limbs.reshape(-1, 3)
    depth = (ends @ camera.rotation[2] + camera.translation[2]).reshape(-1, 2)
    safe = np.maximum(depth, 0.3)
    pixel = project(camera, ends).reshape(-1, 2, 2)
    focal = float(camera.matrix[0, 0])
    across = focal * radius[:, None] / safe
    axis = pixel[:, 1] - pixel[:, 0]
    angle = np.arctan2(axis[:, 1], axis[:, 0])[:, None] + FAN
    round_end = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    tip = pixel[:, 1, None] + across[:, 1, None, None] * round_end
    root = pixel[:, 0, None] - across[:, 0, None, None] * round_end
    polygon = np.concatenate([tip, root], axis=1)
    size = np.array(camera.size)
    with np.errstate(invalid="ignore"):
        in_front = (depth > 0.3).all(axis=1) & (np.abs(pixel).max(axis=(1, 2)) < 2000)
        in_front &= (polygon.max(axis=1) > 0).all(axis=1) & (polygon.min(axis=1) < size).all(axis=1)
    order = np.argsort(-np.linalg.norm(limbs.mean(axis=1) - camera.center, axis=1))
    fixed = np.round(np.where(in_front[:, None, None], polygon, 0) * (1 << SUBPIXEL)).astype(np.int32)
    return fixed, focal / safe.mean(axis=1), order[in_front[order]]


def fill(image: Array, polygon: Array, tone: list[float]) -> None:
    """Fill one outline of :func:`outlines`."""
    cv2.fillConvexPoly(image, polygon, tone, cv2.LINE_AA, SUBPIXEL)


def dot(image: Array, centre: Array, radius: float, tone: list[float]) -> None:
    """A small disc between pixels; centre (2,) and radius in px."""
    x, y, r = (round(float(v) * (1 << SUBPIXEL)) for v in (*centre, radius))
    cv2.circle(image, (x, y), r, tone, -1, cv2.LINE_AA, SUBPIXEL)
