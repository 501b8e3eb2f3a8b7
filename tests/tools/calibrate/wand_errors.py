"""The errors of calibrations by a wand, and what made sightings allow."""

from __future__ import annotations

import numpy as np
from tests.tools.calibrate.rooms import MadeRoom

from followspot_calibrate.similarity import similarity
from followspot_calibrate.wand.solving import Solved

NOISE = 0.4
"""px; from 4 m and with a focal length of 450 px, one sighting is 3.6 mm off."""
KNOWN_MM = 7.0
"""Centres that rest on dozens of sightings are within twice the error of one."""
FREE_MM = 36.0
"""Focal lengths and principal points that must be found as well cost five times as much."""


def differences(solved: Solved, room: MadeRoom):
    """Of centres, mm, and of rotations, degrees, after the best similarity."""
    found = [similar(solved, room).camera(camera) for camera in solved.adjusted.cameras]
    apart = [np.linalg.norm(c.center - true.center) for c, true in zip(found, room.cameras, strict=True)]
    traces = [np.trace(c.rotation @ true.rotation.T) for c, true in zip(found, room.cameras, strict=True)]
    return 1000 * np.array(apart), np.degrees(np.arccos(np.clip((np.array(traces) - 1) / 2, -1, 1)))


def similar(solved: Solved, room: MadeRoom):
    return similarity(
        np.array([camera.center for camera in solved.adjusted.cameras]),
        np.array([camera.center for camera in room.cameras]),
    )
