"""Which pixels show the hues of a target (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

import cv2
import numpy as np

from followspot.messages import Array


def hsv_tiles(tiles: Array) -> Array:
    """Hue (full range), saturation and value of a stack of BGR pictures: (N, h, w, 3) u8."""
    tall = tiles.reshape(-1, *tiles.shape[2:])
    return np.asarray(cv2.cvtColor(tall, cv2.COLOR_BGR2HSV_FULL)).reshape(tiles.shape)


def hue_pixels(hue: Array, member: Array) -> Array:
    """Pixels whose hue belongs to each target.

    hue: (T or 1, h, w) u8, one picture for each target or one for all; member: (T, 256) bool.
    Returns (T, h, w) bool.
    """
    if len(hue) == 1:
        return np.asarray(member[:, hue[0]])
    return np.asarray(member[np.arange(len(hue))[:, None, None], hue])


def target_level(hsv: Array, member: Array, saturation: int, value: int, white: int) -> tuple[Array, Array]:
    """Pixels that show the hue, and the brightness of these and of overexposed cores; 0 elsewhere.

    A core is bright and pale: the sensor saturates where the ball glows most, and its hue is lost.
    hsv: (T or 1, h, w, 3) u8; member: (T, 256) bool. Returns (T, h, w) bool and (T, h, w) u8.
    """
    pale, bright = hsv[..., 1] < saturation, hsv[..., 2]
    colored = hue_pixels(hsv[..., 0], member) & (~pale & (bright >= value))
    sought = colored | (pale & (bright >= white))
    return colored, np.where(sought, bright, np.uint8(0))
