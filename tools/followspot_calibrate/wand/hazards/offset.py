"""Cameras that are a part of a frame out of step: found from how far ahead of the others they see motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Camera
from followspot.geometry import undistort
from followspot.messages import Array
from followspot_calibrate.clocks.estimation import estimated
from followspot_calibrate.clocks.moments import Moments
from followspot_calibrate.sightings import Sightings

RATE = 30.0
"""Frames whose errors depend on each other."""
MOST = 4000
"""Rows that are asked, in stretches spread over the recording; neighbours tell the velocity."""
STRETCH = 40
"""Rows of a stretch."""


@dataclass(frozen=True, eq=False)
class Late:
    """By how many frames cameras are later than most of them, and one standard deviation: (C,) each."""

    frames: Array
    sigma: Array


def lateness(cameras: Sequence[Camera], points: Array, pixel: Array, sightings: Sightings) -> Late:
    """What motion tells of a rest of lateness in tracks that are already nearly in step.

    points: (N, 3); pixel: (N, C, 2) px of the frames and labels of the sightings.
    """
    order = _stretches(np.lexsort([sightings.frame, sightings.label]))
    xy = np.stack([undistort(c, pixel[order, i]) for i, c in enumerate(cameras)], axis=1)
    moments = Moments(
        sightings.frame[order] / RATE, sightings.label[order], points[order], xy, np.zeros(pixel.shape[:2])
    )
    found = estimated(moments, np.array([c.projection for c in cameras]), np.zeros(len(cameras)))
    frames = RATE * found.offset
    return Late(frames - np.median(frames), RATE * found.sigma)


def drift(cameras: Sequence[Camera], points: Array, sightings: Sightings, sure: float, least: float) -> Array:
    """By how many frames lateness grew from the first half to the second, (C,); 0 where that is not sure.

    points: (N, 3); sure: sigmas, and least: frames, of a growth that is believed.
    """
    late = sightings.frame > np.median(sightings.frame)
    first, second = (
        lateness(cameras, points[rows], sightings.pixel[rows], sightings.rows(rows)) for rows in (~late, late)
    )
    grown, sigma = second.frames - first.frames, np.hypot(first.sigma, second.sigma)
    return np.asarray(np.where(np.abs(grown) > np.maximum(least, sure * sigma), grown, 0.0))


def _stretches(order: Array) -> Array:
    """Some of the rows, in whole stretches."""
    parts = max(1, len(order) // STRETCH)
    chosen = np.linspace(0, parts - 1, min(parts, MOST // STRETCH)).astype(int)
    return np.concatenate([np.array_split(order, parts)[part] for part in chosen])
