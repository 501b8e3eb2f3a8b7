"""A body of a known pose before a plain wall, with the background that was learnt of it."""

from __future__ import annotations

import numpy as np
from tests.plugins.persons.drawn import (
    SHIRT,
    WALL,
    perspective,
)

from followspot.geometry import project
from followspot_persons.background.body_axis import BEFORE_AXIS
from followspot_persons.background.scene import Scene


def background_and_body(true):
    """A plain wall as background, and a body of a true pose (6,) before it, from head to feet."""
    camera = perspective()
    pixels = np.full((240, 320, 3), WALL, np.uint8)
    head, foot = project(camera, np.array([true[:3], [*true[:2], 0.0]]))
    back = pixels.copy()
    half = 0.1 * (foot[1] - head[1])
    columns = slice(int(head[0] - half), int(head[0] + half))
    feet = project(camera, np.array([[true[0] - BEFORE_AXIS, true[1], 0.0]]))[0, 1]
    pixels[int(head[1]) : int(feet), columns] = SHIRT
    return Scene(camera, pixels, back, 1.0)
