"""Lines that show a person's pose in a picture: the outline and headings of head and shoulders."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from followspot.geometry import project
from followspot.messages import Array
from followspot.room import Camera

TALL = 1.75
"""Height of the body that the numbers below are of, m."""
SECTIONS = np.array(
    [
        (0.00, 0.00, 0.00),
        (0.05, 0.07, 0.02),
        (0.08, 0.10, 0.10),
        (0.07, 0.09, 0.19),
        (0.05, 0.06, 0.25),
        (0.09, 0.07, 0.28),
        (0.20, 0.10, 0.32),
        (0.22, 0.11, 0.42),
        (0.19, 0.12, 0.55),
        (0.17, 0.12, 0.70),
    ]
)
"""Half the width and half the depth of an adult's body, and how far below the head's top, m."""
HEAD, CHEST = 0.12, 0.45
"""Middle of the head and of the chest below the head's top, m."""
GAZE, FRONT = 0.35, 0.45
"""Lengths of the arrows from head and chest, m."""


def outline(xy: Array, height: float, heading: float, center: Array) -> Array:
    """Silhouette of head and shoulders as seen from a camera's centre, a polyline (2 S, 3) m.

    xy: (2,) m, place on the floor; height: m, of the head's top; heading: rad, of the chest; center: (3,) m,
    of the camera. A section is an ellipse that turns with the chest; S: their number.
    """
    away = xy - center[:2]
    bearing = np.arctan2(away[1], away[0])
    width, depth, below = SECTIONS.T * (height / TALL)
    seen = np.hypot(width * np.cos(heading - bearing), depth * np.sin(heading - bearing))
    across = np.array([-np.sin(bearing), np.cos(bearing)])
    left, right = xy + seen[:, None] * across, xy - seen[:, None] * across
    sides = np.vstack([left[::-1], right])
    return np.column_stack([sides, np.concatenate([height - below[::-1], height - below])])


def arrows(xy: Array, height: float, heading: float, pan: float, tilt: float) -> tuple[Array, Array]:
    """Arrows from head and chest along their headings, each (2, 3) m: begin and end.

    xy: (2,) m, place on the floor; height: m, of the head's top; heading: rad, of the chest; pan, tilt: rad,
    of the head against the chest.
    """
    scale = height / TALL
    gaze, level = heading + pan, np.cos(tilt)
    face = np.array([level * np.cos(gaze), level * np.sin(gaze), np.sin(tilt)])
    front = np.array([np.cos(heading), np.sin(heading), 0.0])
    head, chest = (np.array([*xy, height - below * scale]) for below in (HEAD, CHEST))
    return np.array([head, head + GAZE * face]), np.array([chest, chest + FRONT * front])


def images(camera: Camera, points: Array) -> Iterator[Array]:
    """The polyline (N, 3) m in the picture, as runs (K, 2) px of at least two points.

    It is broken at points without an image and at the seam of a panorama.
    """
    pixel = project(camera, points)
    known = np.asarray(np.isfinite(pixel).all(axis=1))
    jumps = np.abs(np.diff(pixel[:, 0], prepend=pixel[0, 0])) > camera.size[0] / 2
    for run in np.split(np.arange(len(pixel)), np.flatnonzero(jumps | ~known)):
        kept = pixel[run[known[run]]]
        if len(kept) > 1:
            yield kept
