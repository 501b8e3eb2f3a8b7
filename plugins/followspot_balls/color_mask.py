"""Which pixels show the hues of a target (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.hue import BIT
from followspot_balls.strip import Strip, Windows, clusters, cut, row_and_column, scattered, window_strip


class Limits(NamedTuple):
    """When a pixel shows a hue: saturation and value at least that; white: value of an overexposed core."""

    saturation: int
    value: int
    white: int


class Sought(NamedTuple):
    """A strip of what may show the targets."""

    strip: Strip
    owner: Array
    """(N,) row of the target that each part is searched for, among those of all views."""
    level: Array
    """(H, W) u8, brightness of the pixels that may show it, 0 elsewhere."""
    hue: Array
    """(H, W) u8, full range."""
    colored: Array
    """(H, W) bool, pixels that show the hue; the others of the level are overexposed cores."""


def in_windows(
    pictures: Sequence[Array], windows: Windows, owner: Array, hues: Array, limits: Limits
) -> Sought:
    """What may show each target in its window.

    pictures: (H, W, 3) BGR, one for each window; owner: (N,) rows of the targets;
    hues: (rows,) u16, bits of the targets of all views.
    """
    strip = window_strip(windows)
    tiles = cut(pictures, windows)
    hue, saturation, value = (plane.reshape(tiles.shape[:2]) for plane in hsv(tiles))
    colored, core = saturated(saturation, value, limits)
    colored &= (np.asarray(cv2.LUT(hue, BIT)) & hues.take(owner).take(strip.part)) > 0
    return Sought(strip, owner, (colored | core).view(np.uint8) * value, hue, colored)


def in_picture(pixels: Array, owner: Array, hues: Array, limits: Limits, smallest: Array) -> Sought:
    """What may show some targets of one view anywhere in its picture.

    owner: (N,) rows of the targets; smallest: (N,) area, px; others as above.
    """
    height, width = pixels.shape[:2]
    hue, saturation, value = (plane.reshape(-1) for plane in hsv(pixels))
    colored, core = saturated(saturation, value, limits)
    index = np.flatnonzero(colored | core)
    core, hue, value = core.take(index), hue.take(index), value.take(index)
    shown = (BIT.take(hue) & hues.take(owner)[:, None] > 0) & ~core
    layer, entry = row_and_column(np.flatnonzero(shown | core), max(len(index), 1))
    y, x = row_and_column(index.take(entry), width)
    found = clusters(layer, y, x, (len(owner), height, width), smallest)
    entry = entry.take(found.entry)
    planes = (value.take(entry), hue.take(entry), ~core.take(entry))
    return Sought(found.strip, owner.take(found.layer), *(scattered(found, plane) for plane in planes))


def hsv(pixels: Array) -> tuple[Array, ...]:
    """Full-range hue, saturation and value of BGR pixels, one row each: a narrow picture would be slow."""
    planes = cv2.split(cv2.cvtColor(pixels.reshape(1, -1, 3), cv2.COLOR_BGR2HSV_FULL))
    return tuple(np.asarray(plane) for plane in planes)


def saturated(saturation: Array, value: Array, limits: Limits) -> tuple[Array, Array]:
    """Pixels that show a hue, and overexposed cores, bool.

    A core is bright and pale: the sensor saturates where the ball glows most, and its hue is lost.
    """
    pale = saturation < limits.saturation
    return (value >= limits.value) > pale, (value >= limits.white) & pale
