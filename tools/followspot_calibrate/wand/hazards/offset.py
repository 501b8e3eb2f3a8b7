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
from followspot_calibrate.wand.hazards.support import misfit
from followspot_calibrate.wand.hazards.tracks import frame_step, resampled

RATE = 30.0
"""Frames whose errors depend on each other."""
MOST = 2000
"""Rows that are enough, in stretches spread over the recording; neighbours tell the velocity."""
NEAR, STRIDE = 4.0, 0.5
"""Steps up to which a lateness is sought wherever the place, and between two that are tried."""
BETTER = 0.8
"""Error at another lateness over that without, below which it is a better start."""
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
    order = np.lexsort([sightings.frame, sightings.label])
    xy = np.stack([undistort(c, pixel[order, i]) for i, c in enumerate(cameras)], axis=1)
    moments = Moments(
        sightings.frame[order] / RATE, sightings.label[order], points[order], xy, np.zeros(pixel.shape[:2])
    )
    found = estimated(moments, np.array([c.projection for c in cameras]), np.zeros(len(cameras)))
    frames = RATE * found.offset
    return Late(frames - np.median(frames), RATE * found.sigma)


def nearest_shift(camera: Camera, points: Array, sightings: Sightings, number: int) -> float:
    """By how many frames a camera is late, up to `NEAR` steps, wherever its place among the points may be.

    points: (N, 3); number: of the camera. Motion alone is slow to tell what the place of a late camera hides.
    """
    shifts = frame_step(sightings) * np.arange(-NEAR, NEAR + STRIDE, STRIDE)
    late, misfits = np.zeros(len(sightings.cameras)), []
    for shift in shifts:
        late[number] = shift
        misfits.append(misfit(camera, points, resampled(sightings, late)[:, number]))
    best = int(np.argmin(misfits))
    return float(shifts[best]) if misfits[best] < BETTER * misfits[len(shifts) // 2] else 0.0


def drift(
    cameras: Sequence[Camera], points: Array, sightings: Sightings, late: Array, sure: float, least: float
) -> Array:
    """By how many frames lateness grew from the first half to the second, (C,); 0 where that is not sure.

    points: (N, 3); late: (C,) frames, in all; only cameras that are late are asked. sure: sigmas, and least:
    frames, of a growth that is believed.
    """
    pixel, second = resampled(sightings, late), sightings.frame > np.median(sightings.frame)
    before, after = (
        lateness(cameras, points[rows], pixel[rows], sightings.rows(rows)) for rows in (~second, second)
    )
    grown, sigma = after.frames - before.frames, np.hypot(before.sigma, after.sigma)
    believed = (late != 0) & (np.abs(grown) > np.maximum(least, sure * sigma))
    return np.asarray(np.where(believed, grown, 0.0))


def stretches(sightings: Sightings) -> Array:
    """Some of the rows, in whole stretches of time: numbers, by label and frame."""
    order = np.lexsort([sightings.frame, sightings.label])
    parts = max(1, len(order) // STRETCH)
    chosen = np.linspace(0, parts - 1, min(parts, MOST // STRETCH)).astype(int)
    return np.concatenate([np.array_split(order, parts)[part] for part in chosen])
