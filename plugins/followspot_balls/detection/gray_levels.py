"""Pixels of infrared pictures whose grey level is that of a ball."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot_balls.detection.strip import Strip, clusters, row_and_column, scattered


class Limits(NamedTuple):
    """Limits of brightness and area of a ball in each of V views."""

    darkest: Array
    """(V,) u8."""
    brightest: Array
    """(V,) u8."""
    smallest: Array
    """(V,) px, of any target."""
    largest: Array
    """(V,) px, of any target."""
    areas: Array
    """(V, T, 2) smallest and largest of each target, px."""


def in_pictures(pictures: Sequence[Array], view: Array, limits: Limits) -> tuple[Array, Strip, Array]:
    """Pixels of whole pictures in the range of their views, gathered into a strip; the view of each part.

    pictures: (H, W, 1) of V views, which may differ in size; view: (V,) their numbers.
    """
    places, grays = zip(
        *map(bright, pictures, limits.darkest.take(view), limits.brightest.take(view)), strict=True
    )
    layer = np.arange(len(view)).repeat([len(place) for place in places])
    height, width, _ = np.array([pixels.shape for pixels in pictures]).T
    y, x = row_and_column(np.concatenate(places), width.take(layer))
    size = len(view), int(height.max()), int(width.max())
    found = clusters(layer, y, x, size, limits.smallest.take(view))
    gray = np.concatenate(grays).take(found.entry)
    return scattered(found.shape, found.place, gray), found.strip, view.take(found.layer)


def bright(pixels: Array, darkest: Array, brightest: Array) -> tuple[Array, Array]:
    """Flat index and grey level of the pixels in a range. pixels: (H, W, 1)."""
    # one pass over a channel of several, and fast ones from then on
    gray = np.ascontiguousarray(pixels[..., 0])
    shown = gray >= darkest
    shown &= gray <= brightest
    place = shown.reshape(-1).nonzero()[0]
    return place, gray.reshape(-1).take(place)


def in_range(gray: Array, limits: Limits, view: Array) -> Array:
    """Grey levels in the range of their view, 0 elsewhere. gray: (H, W) u8; view: (W,)."""
    shown = (gray >= limits.darkest.take(view)) & (gray <= limits.brightest.take(view))
    return np.asarray(shown.view(np.uint8) * gray)
