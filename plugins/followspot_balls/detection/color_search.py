"""Blobs in the colours of targets, in the pictures of all cameras at once (Jin & Qian 2008, section 2.1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot import Array
from followspot_balls.detection.color_mask import Limits, Sought, in_pictures, in_windows
from followspot_balls.detection.color_params import ColorParams
from followspot_balls.detection.components import Components, above_local_peak, clipped, components, of_size
from followspot_balls.detection.hough import disc_centers, own_area
from followspot_balls.detection.hue import BINS, bhattacharyya, normalised
from followspot_balls.detection.rival_colors import best_fitting
from followspot_balls.detection.search_circles import Circles, Regions
from followspot_balls.detection.strip import Windows, abreast

NEVER_TOO_LARGE = 12.0
"""Area up to which no blob is too large for its forecast, px: pixels are coarse."""


class Found(NamedTuple):
    """Blobs of some targets."""

    pixel: Array
    area: Array
    similarity: Array
    owner: Array
    """(N,) row of the target among those of all views."""


NOTHING = Found(np.empty((0, 2)), np.empty(0), np.empty(0), np.empty(0, int))


class Templates(NamedTuple):
    """Templates of the targets in some views: a row for each target of each view in turn."""

    histograms: Array
    """(rows, 16) hue, normalised."""
    hues: Array
    """(rows,) u16, bits of the hues of the target."""
    area: Array
    """(rows, 2) smallest and largest, px."""
    rival: Array
    """(rows, T) bool, the targets whose blobs are taken for those of the target, and the other way round."""


def blobs_of(pictures: Sequence[Array], regions: Regions, templates: Templates, p: ColorParams) -> Found:
    """Blobs of targets in their windows, for all views at once; lost targets are sought in whole pictures."""
    limits = Limits(p.minimum_saturation, p.minimum_brightness, p.overexposed_brightness)
    count = len(regions.circles.lost) // len(pictures)
    found = [NOTHING]
    if len(regions.near):
        shown = [pictures[number] for number in (regions.near // count).tolist()]
        windows = abreast(regions.corners, regions.sides)
        sought = in_windows(shown, windows, regions.near, templates.hues, limits)
        found.append(measured(sought, templates, p, count, (regions.circles, windows)))
    lost = regions.circles.lost.reshape(len(pictures), count)
    target = np.asarray(lost.any(axis=0)).nonzero()[0]
    if len(target):
        rows = np.arange(len(pictures))[:, None] * count + target
        bits = templates.hues.take(rows) * lost.take(target, axis=1)
        owner = rows.reshape(-1)
        smallest = templates.area[:, 0].take(owner)
        sought = in_pictures(pictures, owner, bits, limits, smallest)
        found.append(measured(sought, templates, p, count))
    blobs = found[-1] if len(found) < 3 else Found(*map(np.concatenate, zip(*found, strict=True)))
    if not np.count_nonzero(templates.rival):
        return blobs
    return Found(*(column[best_fitting(*blobs, templates.rival)] for column in blobs))


def measured(
    sought: Sought,
    templates: Templates,
    p: ColorParams,
    count: int,
    near: tuple[Circles, Windows] | None = None,
) -> Found:
    """Blobs of the targets in the parts of a strip.

    count: targets of each view; near: search regions, if the parts are their windows.
    """
    strip = sought.strip
    blobs = components(above_local_peak(sought.level, p.edge_level), sought.level, strip)
    owner = sought.owner.take(blobs.part)
    smallest, largest = templates.area.take(owner, axis=0).T
    keep = of_size(blobs.area, smallest, largest if near is None else np.inf, owner // max(count, 1))
    histograms = component_histograms(blobs, sought.hue)
    similarity = bhattacharyya(histograms, templates.histograms.take(owner, axis=0))
    keep &= similarity > p.similarity
    pixel, area = blobs.center, blobs.area
    if near is not None:
        circles, windows = near
        keep &= ~clipped(blobs, strip, windows)
        regions = Circles(*(column.take(owner, axis=0) for column in circles))
        pixel, area, fits = discs(sought, blobs, regions, largest, keep, p)
        keep &= fits
    rows = keep.nonzero()[0]
    return Found(pixel.take(rows, axis=0), area.take(rows), similarity.take(rows), owner.take(rows))


def discs(
    sought: Sought, blobs: Components, regions: Circles, largest: Array, keep: Array, p: ColorParams
) -> tuple[Array, Array, Array]:
    """Each blob as a disc of the size that is expected at the forecast.

    regions: the search region of each of N blobs; largest: (N,) px, area; keep: (N,) bool, blobs whose centre
    is needed. Returns the centres (N, 2) px, the areas (N,) px without light beside the ball, and which lie
    in their region and are not too large, (N,) bool.
    """
    ball = regions.ball
    radius = np.where(keep, ball + p.radius_offset, np.nan)
    pixel, rim = disc_centers(
        sought.level, sought.strip, blobs, radius, p.edge_level, regions.center, regions.beside
    )
    expected = np.maximum(p.maximum_expected_area * np.pi * ball * ball, NEVER_TOO_LARGE)
    bound = np.minimum(largest, expected)
    area = own_area(blobs.area, bound, radius, rim)
    right, down = (pixel - regions.center).T
    return pixel, area, (area <= bound) & (np.hypot(right, down) <= regions.radius)


def component_histograms(blobs: Components, hue: Array) -> Array:
    """Normalised hue histogram (eq. 1) of each component over its coloured pixels: (N, 16).

    hue: (H, W) u8 of the strip, bins; `BINS` in an overexposed core.
    """
    count = len(blobs.area)
    cells = blobs.label * (BINS + 1) + hue.take(blobs.pixels)
    counts = np.bincount(cells, minlength=count * (BINS + 1)).reshape(count, BINS + 1)
    return normalised(counts[:, :BINS])
