"""Which pixels show the hues of a target (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array


class Hsv(NamedTuple):
    """Hue (full range), saturation and value of a stack of pictures: (N, h, w) u8 each."""

    hue: Array
    saturation: Array
    value: Array


def hsv_tiles(tiles: Array) -> Hsv:
    """Of BGR pictures, (N, h, w, 3) u8."""
    tall = tiles.reshape(-1, *tiles.shape[2:])
    planes = cv2.split(cv2.cvtColor(tall, cv2.COLOR_BGR2HSV_FULL))
    return Hsv(*(np.asarray(plane).reshape(tiles.shape[:3]) for plane in planes))


def hue_pixels(hue: Array, member: Array) -> Array:
    """Pixels whose hue belongs to each target.

    hue: (T or 1, h, w) u8, one picture for each target or one for all; member: (T, 256) bool.
    Returns (T, h, w) bool.
    """
    shown = np.empty((len(member), *hue.shape[1:]), np.uint8)
    for number, table in enumerate(member.view(np.uint8)):
        cv2.LUT(hue[number % len(hue)], table, dst=shown[number])
    return shown.view(bool)


def target_level(hsv: Hsv, member: Array, saturation: int, value: int, white: int) -> tuple[Array, Array]:
    """Pixels that show the hue, and the brightness of these and of overexposed cores; 0 elsewhere.

    A core is bright and pale: the sensor saturates where the ball glows most, and its hue is lost.
    hsv: of one picture for each target or of one for all; member: (T, 256) bool. Returns (T, h, w) bool
    and (T, h, w) u8.
    """
    pale = hsv.saturation < saturation
    colored = hue_pixels(hsv.hue, member) & (~pale & (hsv.value >= value))
    sought = colored | (pale & (hsv.value >= white))
    return colored, sought.view(np.uint8) * hsv.value
