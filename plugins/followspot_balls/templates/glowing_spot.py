"""Detection of a glowing target in a clip: in each frame the bright, compact spot that is similar in all
frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.detection.components import above_local_peak

CONTRAST = 40
"""How much brighter than the room without it the target must be, grey levels."""
SMALLEST = 4
"""Area below which a bright spot is no target but noise, px."""
COMPACT = 0.4
"""Smallest area over that of a disc of the same width: below it are people and stripes, but no fast ball."""
AS_BRIGHT = 0.85
"""Level over the brightest in the frame above which a spot may be the target; the largest of these is."""
RING, ISLAND = 5, 0.5
"""Width of the ring around a spot, px, and its largest brightness over that of the spot."""
MOST = 20
"""Number of tested spots of a frame, the largest first."""
DIMMER = 0.35
"""Level over the usual one of the clip below which a spot is lit, but does not glow."""
APART = 4.0
"""Largest ratio of a spot's area to the usual area of the clip."""


class Spot(NamedTuple):
    """The target in one frame: number of the frame, mask (H, W) bool, mean grey level, area in px."""

    frame: int
    inside: Array
    level: float
    area: float


def glowing(levels: Sequence[Array], edge: float) -> list[Spot]:
    """The target in each frame that shows it; people may walk through the picture.

    People and reflections are dimmer than a glowing target, not compact, or of another size than it has in
    most frames. The median frame is subtracted, so that hot pixels and lamps are not mistaken for a moving
    target. Raises ValueError if nothing glows.
    levels: (H, W) u8 pictures; edge: of a blob over its brightest pixel.
    """
    stack = _stacked(levels)
    room = np.median(stack, axis=0) if len(stack) > 2 else np.zeros(stack.shape[1:])
    found = (_brightest(number, level, room, edge) for number, level in enumerate(stack))
    spots = consistent([spot for spot in found if spot is not None])
    if not spots:
        raise ValueError(
            f"none of {len(stack)} frames shows a moving spot of at least {SMALLEST} px "
            f"that is {CONTRAST} grey levels brighter than the room"
        )
    return spots


def brightness(picture: Array) -> Array:
    """The largest channel of each pixel, (H, W, C) -> (H, W); `max(axis=2)` would go pixel by pixel."""
    return np.asarray(reduce(np.maximum, np.moveaxis(picture, 2, 0)))


def consistent(spots: Sequence[Spot]) -> list[Spot]:
    """The spots with about the brightness and area of the brighter spots of the clip."""
    if not spots:
        return []
    usual = float(np.percentile([spot.level for spot in spots], 75))
    bright = [spot for spot in spots if spot.level >= DIMMER * usual]
    size = float(np.median([spot.area for spot in bright if spot.level >= usual * AS_BRIGHT]))
    return [spot for spot in bright if size / APART <= spot.area <= size * APART]


def _brightest(number: int, level: Array, room: Array, edge: float) -> Spot | None:
    """The largest of the brightest compact spots of one frame."""
    risen = np.where(level > room + CONTRAST, level, 0).astype(np.uint8)
    mask = above_local_peak(risen, edge).view(np.uint8)
    _, label, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8, ltype=cv2.CV_32S)
    area = stats[1:, cv2.CC_STAT_AREA]  # the first is the background
    side = stats[1:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1)
    glow = np.bincount(label.reshape(-1), risen.reshape(-1))[1:] / area
    compact = (area >= SMALLEST) & (area >= COMPACT * np.pi / 4 * side * side)
    if not compact.any():
        return None
    bright = np.flatnonzero(compact & (glow >= AS_BRIGHT * glow[compact].max()))
    for chosen in bright[np.argsort(-area[bright], kind="stable")][:MOST].tolist():
        inside = np.asarray(label == chosen + 1)
        if _stands_out(risen, inside):
            return Spot(number, inside, float(glow[chosen]), float(area[chosen]))
    return None


def _stands_out(risen: Array, inside: Array) -> bool:
    """Whether a spot is isolated: a part of a lit shirt is surrounded by the rest of the shirt."""
    near = cv2.dilate(inside.view(np.uint8), np.ones((3, 3), np.uint8))
    ring = cv2.dilate(near, np.ones((RING, RING), np.uint8)) > near
    return bool(risen[ring].mean() < ISLAND * risen[inside].mean())


def _stacked(levels: Sequence[Array]) -> Array:
    if not levels:
        raise ValueError("the clip has no frames")
    stack = np.stack(levels)
    if not np.ptp(stack, axis=0).any() and len(stack) > 1:
        raise ValueError("nothing moves in this clip")
    return stack
