"""Cameras of the sizes for which detectors of persons were tried."""

from __future__ import annotations

import numpy as np

from followspot import Camera

FACING = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])
PLACE = -FACING @ [0, 0, 1.2]
"""A level camera 1.2 m above the origin that looks along x."""


def panorama():
    f = 1396 / (2 * np.pi)
    matrix = np.array([[f, 0, 697.5], [0, f, 129.5], [0, 0, 1]])
    return Camera("c", "color", (1396, 260), matrix, np.zeros(5), FACING, PLACE, "cylinder")


def perspective():
    matrix = np.array([[457.0, 0, 319.5], [0, 457.0, 239.5], [0, 0, 1]])
    return Camera("c", "color", (640, 480), matrix, np.zeros(5), FACING, PLACE)
