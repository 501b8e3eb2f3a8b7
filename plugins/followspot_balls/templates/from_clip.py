"""Templates of a target, learnt from a clip of it in a dark room (Jin & Qian 2008, section 3.2).

The frames are those of one camera; the target glows, moves and may be out of view in some of them; a person
may carry it in view.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from followspot.messages import Array
from followspot_balls.detection.hue import BINS, bhattacharyya, hue_bin, normalised
from followspot_balls.templates.glowing_spot import brightness, glowing

COLOR_EDGE, INFRARED_EDGE = 0.7, 0.45
"""Edge of a blob over its brightest pixel, as in the detectors."""
VIVID = 80
"""Smallest saturation of a pixel that shows its hue."""
ALIKE = 0.6
"""Smallest similarity of a spot's hues with those of the clip; a spot of another colour is no target."""


class ColorSpots(NamedTuple):
    """A target in S frames of a clip: counts (S, 16) of coloured pixels by hue, area (S,) px."""

    counts: Array
    area: Array

    @property
    def extremes(self) -> tuple[float, float]:
        """Smallest and largest area, px."""
        return float(self.area.min()), float(self.area.max())


def color_spots(frames: Sequence[Array]) -> ColorSpots:
    """The target in each frame that shows it: spots of one colour. Raises ValueError if there are none."""
    spots = glowing([brightness(frame) for frame in frames], COLOR_EDGE)
    counts = np.zeros((len(spots), BINS))
    for number, spot in enumerate(spots):
        hsv = cv2.cvtColor(frames[spot.frame], cv2.COLOR_BGR2HSV_FULL)[spot.inside]
        counts[number] = np.bincount(hue_bin(hsv[hsv[:, 1] >= VIVID, 0]), minlength=BINS)
    if not counts.any():
        raise ValueError("the bright spot that moves has no colour; is it overexposed?")
    # A spot without any hue is the overexposed target; the usual hue is that of the median spot, which
    # no single large thing can change.
    usual = normalised(np.median(normalised(counts[counts.any(axis=1)]), axis=0))
    alike = ~counts.any(axis=1) | (bhattacharyya(normalised(counts), usual) >= ALIKE)
    if not counts[alike].any():
        raise ValueError("the bright spots that move have no colour in common; show the target alone")
    area = np.array([spot.area for spot in spots])
    return ColorSpots(counts[alike], area[alike])


def color_template(spots: ColorSpots) -> Array:
    """Hue histogram (16,) of all coloured pixels, normalised."""
    return normalised(spots.counts.sum(axis=0))


def learn_infrared(frames: Sequence[Array]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Lowest and highest grey level, and smallest and largest area in px, of a reflective target.

    frames: pictures (H, W) or (H, W, channels) u8. Raises ValueError if no target is seen.
    """
    grays = [frame if frame.ndim == 2 else frame[..., 0] for frame in frames]
    spots = glowing(grays, INFRARED_EDGE)
    lowest = min(float(grays[spot.frame][spot.inside].min()) for spot in spots)
    highest = max(float(grays[spot.frame][spot.inside].max()) for spot in spots)
    area = [spot.area for spot in spots]
    return (lowest, highest), (min(area), max(area))
