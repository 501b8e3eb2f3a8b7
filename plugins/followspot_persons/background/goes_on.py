"""Whether foreground that leaves a part of a picture at its side goes on below it."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array


def goes_on_below(foreground: Array, part: tuple[slice, slice], margin: int) -> bool:
    """Whether foreground in a part is connected with foreground more than `margin` rows below the part.

    foreground: (H, W) bool; part: its rows and columns.
    """
    labels, stats = cv2.connectedComponentsWithStats(foreground.astype(np.uint8))[1:3]
    ends = stats[:, cv2.CC_STAT_TOP] + stats[:, cv2.CC_STAT_HEIGHT]
    inside = np.unique(labels[part])
    return bool((ends[inside[inside > 0]] > part[0].stop + margin).any())
