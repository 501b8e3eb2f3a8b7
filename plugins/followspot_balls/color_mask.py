"""Which pixels show the hues of a target (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.hue import BINS, BIT, hue_bin
from followspot_balls.strip import Strip, Windows, clusters, cut, row_and_column, scattered, window_strip


class Limits(NamedTuple):
    """Smallest saturation and value of a pixel that shows a hue; white: smallest value of an overexposed
    core.
    """

    saturation: int
    value: int
    white: int


class Lit(NamedTuple):
    """The P bright pixels of a picture. They are few, which makes further tests cheap."""

    place: Array
    """(P,) flat index."""
    value: Array
    """(P,) u8, brightness."""
    hue: Array
    """(P,) u8, bin of the hue; `BINS` in an overexposed core."""


class Sought(NamedTuple):
    """A strip with the pixels that may show the targets."""

    strip: Strip
    owner: Array
    """(N,) row of the target that each part is searched for, among those of all views."""
    level: Array
    """(H, W) u8, brightness of the pixels that may show it, 0 elsewhere."""
    hue: Array
    """(H, W) u8, of these pixels the bin of the hue; `BINS` in an overexposed core."""


def in_windows(
    pictures: Sequence[Array], windows: Windows, owner: Array, hues: Array, limits: Limits
) -> Sought:
    """Pixels that may show each target in its window.

    pictures: (H, W, 3) BGR, one for each window; owner: (N,) rows of the targets;
    hues: (rows,) u16, bits of the targets of all views.
    """
    strip = window_strip(windows)
    tiles = cut(pictures, windows)
    found = lit(tiles, limits)
    _, x = row_and_column(found.place, tiles.shape[1])
    wanted = hues.take(owner).take(strip.part).take(x)
    entry = (BIT.take(found.hue) & wanted).nonzero()[0]
    place = found.place.take(entry)
    planes = (scattered(tiles.shape[:2], place, plane.take(entry)) for plane in (found.value, found.hue))
    return Sought(strip, owner, *planes)


def in_picture(pixels: Array, owner: Array, hues: Array, limits: Limits, smallest: Array) -> Sought:
    """Pixels that may show some targets of one view anywhere in its picture.

    owner: (N,) rows of the targets; smallest: (N,) area, px; others as above.
    """
    height, width = pixels.shape[:2]
    place, *planes = lit(pixels, limits)
    shown = BIT.take(planes[1]) & hues.take(owner)[:, None]
    layer, entry = row_and_column(shown.reshape(-1).nonzero()[0], max(len(place), 1))
    y, x = row_and_column(place.take(entry), width)
    found = clusters(layer, y, x, (len(owner), height, width), smallest)
    entry = entry.take(found.entry)
    scenes = (scattered(found.shape, found.place, plane.take(entry)) for plane in planes)
    return Sought(found.strip, owner.take(found.layer), *scenes)


def lit(pixels: Array, limits: Limits) -> Lit:
    """Pixels that show a hue, or are overexposed cores. pixels: (H, W, 3) BGR.

    An overexposed core is bright and pale: the sensor saturates at the brightest part of the ball.
    """
    brightest_dark = min(limits.value, limits.white) - 1
    _, bright = cv2.threshold(pixels, brightest_dark, 255, cv2.THRESH_BINARY)  # of each colour by itself
    place = (np.asarray(cv2.cvtColor(bright, cv2.COLOR_BGR2GRAY)) > 0).reshape(-1).nonzero()[0]
    if not len(place):
        return Lit(place, *np.empty((2, 0), np.uint8))
    colors = cv2.cvtColor(pixels.reshape(1, -1, 3).take(place, axis=1), cv2.COLOR_BGR2HSV_FULL)
    hue, saturation, value = np.asarray(colors)[0].T
    pale = saturation < limits.saturation
    rows = (value >= np.where(pale, limits.white, limits.value)).nonzero()[0]
    hue = np.where(pale, np.uint8(BINS), hue_bin(hue))
    return Lit(place.take(rows), value.take(rows), hue.take(rows))
