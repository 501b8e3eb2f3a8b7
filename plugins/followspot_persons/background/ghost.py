"""Ghosts: foreground where the background still shows a person who has left (Cucchiara et al. 2003).

At both a person and a ghost the picture differs from the background. The outline of a person is in the
picture, that of a ghost in the background.
"""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array


def is_ghost(part: Array, picture: Array, background: Array, light: float) -> bool:
    """Whether the background has the stronger edges along the outline of a part of the foreground.

    part: (H, W) bool; picture, background: (H, W, 3) u1; light: how bright the picture is over the other.
    """
    outline = cv2.morphologyEx(part.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 0
    if not outline.any():
        return False
    now, then = (_edges(pixels)[outline].mean() for pixels in (picture, background))
    return bool(now < light * then)


def _edges(pixels: Array) -> Array:
    """Strength of edges, (H, W, 3) u1 -> (H, W) f4."""
    smooth = cv2.GaussianBlur(pixels, (3, 3), 0)
    across, down = (cv2.Scharr(smooth, cv2.CV_32F, *axis) for axis in ((1, 0), (0, 1)))
    blue, green, red = np.moveaxis(np.hypot(across, down), 2, 0)
    return np.asarray(np.maximum(np.maximum(blue, green), red))  # as max(axis=2) of three columns, but faster
