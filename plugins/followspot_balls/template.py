"""Templates of a target, learnt from a clip of it alone in a dark room (Jin & Qian 2008, section 3.2).

The frames are those of one camera; the target glows, moves and may be out of view in some of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.components import above_local_peak, components
from followspot_balls.hue import BINS, hue_bin, normalised
from followspot_balls.strip import whole_strip

CONTRAST = 40
"""How much brighter than the room without it the target must be, grey levels."""
SMALLEST = 4
"""Area below which a bright spot is no target but noise, px."""
COLOR_EDGE, INFRARED_EDGE = 0.7, 0.45
"""Edge of a blob over its brightest pixel, as in the detectors."""
VIVID = 80
"""Least saturation of a pixel that shows its hue."""


def learn_color(frames: Sequence[Array]) -> tuple[Array, tuple[float, float]]:
    """Hue histogram (16,), normalised, and smallest and largest area in px of a glowing target.

    frames: BGR pictures (H, W, 3) u8. Raises ValueError where no target is seen.
    """
    spots = find_spots([frame.max(axis=2) for frame in frames], COLOR_EDGE)
    counts = np.zeros(BINS)
    for number, inside in spots:
        hsv = cv2.cvtColor(frames[number], cv2.COLOR_BGR2HSV_FULL)[inside]
        counts += np.bincount(hue_bin(hsv[hsv[:, 1] >= VIVID, 0]), minlength=BINS)
    if not counts.any():
        raise ValueError("the bright spot that moves has no colour; is it overexposed?")
    return normalised(counts), area_range(spots)


def learn_infrared(frames: Sequence[Array]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Lowest and highest grey level, and smallest and largest area in px, of a reflective target.

    frames: pictures (H, W) or (H, W, channels) u8. Raises ValueError where no target is seen.
    """
    grays = [frame if frame.ndim == 2 else frame[..., 0] for frame in frames]
    spots = find_spots(grays, INFRARED_EDGE)
    lowest = min(float(grays[number][inside].min()) for number, inside in spots)
    highest = max(float(grays[number][inside].max()) for number, inside in spots)
    return (lowest, highest), area_range(spots)


def area_range(spots: Sequence[tuple[int, Array]]) -> tuple[float, float]:
    """Smallest and largest area, px."""
    areas = [float(inside.sum()) for _, inside in spots]
    return min(areas), max(areas)


def find_spots(levels: Sequence[Array], edge: float) -> list[tuple[int, Array]]:
    """The largest spot brighter than the room in each frame that has one: number of the frame, mask.

    The room is the median frame, so that hot pixels and lamps are not taken for a target that moves.
    """
    if not levels:
        raise ValueError("the clip has no frames")
    stack = np.stack(levels)
    if not np.ptp(stack, axis=0).any() and len(stack) > 1:
        raise ValueError("nothing moves in this clip")
    room = np.median(stack, axis=0) if len(stack) > 2 else np.zeros(stack.shape[1:])
    spots = []
    for number, level in enumerate(stack):
        risen = np.where(level > room + CONTRAST, level, 0).astype(np.uint8)
        found = components(above_local_peak(risen, edge), risen, whole_strip(risen.shape[1]))
        if found.area.max(initial=0) >= SMALLEST:
            inside = np.zeros(risen.shape, bool)
            inside.reshape(-1)[found.pixels] = found.label == found.area.argmax()
            spots.append((number, inside))
    if not spots:
        raise ValueError(
            f"none of {len(stack)} frames shows a moving spot of at least {SMALLEST} px "
            f"that is {CONTRAST} grey levels brighter than the room"
        )
    return spots
