"""Depth as colours: warm is near, cold is far, black is what was not measured."""

from __future__ import annotations

import cv2
import numpy as np

from followspot.messages import Array

_NEAR, _FAR = 240, 20
"""Rows of the colour map; those beyond are nearly black."""


def depth_picture(depth: Array, farthest: float) -> Array:
    """The picture of a depth image, (H, W) m: (H, W, 3) BGR; `farthest` has the last colour."""
    measured = np.isfinite(depth) & (depth > 0)
    share = np.where(measured, depth, 0.0) / farthest
    picture = _colored(share)
    picture[~measured] = 0
    return picture


def scale_colors(count: int) -> list[str]:
    """CSS colours of equally many depths from 0 to the farthest."""
    return [f"#{r:02x}{g:02x}{b:02x}" for b, g, r in _colored(np.linspace(0, 1, count)[None])[0].tolist()]


def _colored(share: Array) -> Array:
    """Colours of depths as shares of the farthest: (H, W, 3) BGR."""
    row = np.rint(_NEAR + (_FAR - _NEAR) * np.clip(share, 0, 1)).astype("u1")
    return np.asarray(cv2.applyColorMap(row, cv2.COLORMAP_TURBO))
