"""Gradients as a picture: orientation as hue, magnitude as brightness (Weinrich et al. 2010, figure 2)."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array, Stage
from followspot.people import Gradients
from followspot.tracking import Frame

HUES = 180
"""Hues of OpenCV, for half a turn of orientations."""


class GradientPicture(Stage):
    """Show gradients in colours: orientation as hue, magnitude as brightness.

    `spread_radius: 1` of `persons.gradients` before it shows the raw gradients, a larger one the spread ones.
    """

    per_camera = True

    def process(self, gradients: Gradients) -> Frame:
        return Frame(gradients.camera, gradient_colors(gradients.magnitude, gradients.orientation))


def gradient_colors(magnitude: Array, orientation: Array) -> Array:
    """(H, W) u1 each, orientation in pi/256 -> (H, W, 3) u1 BGR."""
    hue = (orientation.astype(np.uint16) * HUES >> 8).astype(np.uint8)
    full = np.full_like(magnitude, 255)
    return np.asarray(cv2.cvtColor(cv2.merge([hue, full, magnitude]), cv2.COLOR_HSV2BGR))
