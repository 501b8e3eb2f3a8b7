"""Which pixels show the hues of a target (Jin & Qian 2008, sections 2.1 and 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.detection.hue import BINS, BIT, hue_bin
from followspot_balls.detection.strip import (
    Strip,
    Windows,
    clusters,
    cut,
    row_and_column,
    scattered,
    window_strip,
)


class Limits(NamedTuple):
    """Smallest saturation and value of a pixel that shows a hue; white: smallest value of an overexposed
    core.
    """

    saturation: int
    value: int
    white: int


class Lit(NamedTuple):
    """P pixels that show a hue. They are few, which makes further tests cheap."""

    entry: Array
    """(P,) row among the bright pixels."""
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


def in_pictures(
    pictures: Sequence[Array], owner: Array, bits: Array, limits: Limits, smallest: Array
) -> Sought:
    """Pixels that may show some targets anywhere in the pictures of V views.

    pictures: (H, W, 3) BGR of each view, which may differ in size; owner: (V * T,) rows of targets of each
    view in turn; bits: (V, T) u16, of their hues, 0 for one that the view does not seek; smallest: (V * T,)
    area, px.
    """
    places = [bright(pixels, limits) for pixels in pictures]
    colors = [
        pixels.reshape(-1, 3).take(place, axis=0) for pixels, place in zip(pictures, places, strict=True)
    ]
    view = np.arange(len(pictures)).repeat([len(place) for place in places])
    found = shown(np.concatenate(places), np.concatenate(colors), limits)
    view = view.take(found.entry)
    height, width, _ = np.array([pixels.shape for pixels in pictures]).T
    y, x = row_and_column(found.place, width.take(view))
    table = (BIT & bits.T[..., None] != 0).reshape(-1, bits.shape[0] * len(BIT))
    wanted = table.take(view * len(BIT) + found.hue, axis=1)
    target, entry = row_and_column(wanted.reshape(-1).nonzero()[0], max(len(view), 1))
    layer = view.take(entry) * bits.shape[1] + target
    size = len(owner), int(height.max()), int(width.max())
    gathered = clusters(layer, y.take(entry), x.take(entry), size, smallest)
    entry = entry.take(gathered.entry)
    planes = (
        scattered(gathered.shape, gathered.place, plane.take(entry)) for plane in (found.value, found.hue)
    )
    return Sought(gathered.strip, owner.take(gathered.layer), *planes)


def lit(pixels: Array, limits: Limits) -> Lit:
    """Pixels that show a hue, or are overexposed cores. pixels: (H, W, 3) BGR."""
    place = bright(pixels, limits)
    return shown(place, pixels.reshape(-1, 3).take(place, axis=0), limits)


def bright(pixels: Array, limits: Limits) -> Array:
    """Flat index of the pixels that are bright enough: (P,). pixels: (H, W, 3) BGR."""
    brightest_dark = min(limits.value, limits.white) - 1
    _, above = cv2.threshold(pixels, brightest_dark, 255, cv2.THRESH_BINARY)  # of each colour by itself
    return (np.asarray(cv2.cvtColor(above, cv2.COLOR_BGR2GRAY)) > 0).reshape(-1).nonzero()[0]


def shown(place: Array, colors: Array, limits: Limits) -> Lit:
    """Those of P pixels that show a hue, or are overexposed cores. colors: (P, 3) BGR.

    An overexposed core is bright and pale: the sensor saturates at the brightest part of the ball.
    """
    if not len(place):
        return Lit(place, place, *np.empty((2, 0), np.uint8))
    hue, saturation, value = np.asarray(cv2.cvtColor(colors[None], cv2.COLOR_BGR2HSV_FULL))[0].T
    pale = saturation < limits.saturation
    entry = np.where(pale, value >= limits.white, value >= limits.value).nonzero()[0]
    hue = np.where(pale, np.uint8(BINS), hue_bin(hue))
    return Lit(entry, place.take(entry), value.take(entry), hue.take(entry))
