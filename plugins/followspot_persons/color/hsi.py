"""Hue, saturation and intensity, the decorrelated colours that shadows change least (section 3.3)."""

from __future__ import annotations

import numpy as np

from followspot import Array

TURN = np.float32(1 / (2 * np.pi))


def hsi(pixels: Array) -> Array:
    """Colours of pixels, (..., 3) u1 BGR, as hue (share of the circle), saturation and intensity.

    Returns (..., 3) float32, 0 to 1; the hue of a grey is 0.
    """
    blue, green, red = (pixels[..., i].astype(np.float32) for i in range(3))
    total = blue + green + red
    least = np.minimum(np.minimum(blue, green), red)
    out = np.empty((3, *total.shape), np.float32)  # each channel by itself in memory
    hue, saturation, intensity = out
    np.arctan2(np.float32(np.sqrt(3)) * (green - blue), 3 * red - total, out=hue)
    hue *= TURN
    hue += hue < 0
    np.divide(least, np.maximum(total, 1), out=saturation)
    saturation *= -3
    saturation += 1
    np.multiply(total, np.float32(1 / 765), out=intensity)
    return np.moveaxis(out, 0, -1)


def plane(colors: Array) -> Array:
    """HSI as points of a double cone, (..., 3): saturation towards hue 0, towards hue 1/4, and intensity.

    Here colours can be averaged and compared across the jump of the hue.
    """
    angle = colors[..., 0] * (2 * np.pi)
    return np.stack([colors[..., 1] * np.cos(angle), colors[..., 1] * np.sin(angle), colors[..., 2]], axis=-1)


def from_plane(points: Array) -> Array:
    """Inverse of :func:`plane`."""
    hue = np.arctan2(points[..., 1], points[..., 0]) / (2 * np.pi) % 1.0
    saturation = np.minimum(np.hypot(points[..., 0], points[..., 1]), 1.0)
    return np.stack([hue, saturation, np.clip(points[..., 2], 0, 1)], axis=-1)
