"""Alignment of the blobs of unsynchronised cameras to one time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot.frame_times import NANOSECOND
from followspot.messages import Array
from followspot.tracking import Blobs, Forecast
from followspot_balls.detection.search_circles import search_radius
from followspot_balls.scene.targets import lost_targets

SCALE = 1.5
"""Search radius of a target's image over its travel from frame to frame (Jin & Qian 2008, eq. 3)."""


def delays(blobs: Sequence[Blobs], clock_offset: Array) -> Array:
    """Delay of each camera's blobs after the time of the joined messages: (M,) s.

    clock_offset: (M,) s, by which each camera's time stamps are early. Messages are joined at the earliest.
    """
    times = [b.header.time for b in blobs]
    first = min(times)
    return np.asarray(clock_offset + [(time - first) * NANOSECOND for time in times])


def aligned(
    xy: Array, view: Array, targets: Array, delay: Array, P: Array, forecast: Forecast, minimum: float
) -> Array:
    """The blobs corrected for their cameras' delays: (N, 2) px.

    A blob moves as the image of its target does, for the forecast X and v: by P(X + v delay) - P(X). A blob
    near several targets belongs to the nearest one; a blob out of reach of all targets stays.
    xy: (N, 2) px, undistorted; view: (N,) numbers of the cameras; targets: (N, T) bool; delay: (C,) s;
    P: (C, 3, 4); minimum: px, smallest reach.
    """
    lost = lost_targets(forecast, targets.shape[1])
    if lost.all():
        return xy
    now, later, travel = motion_images(P, delay, forecast)
    offset = xy[:, None] - later[view]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    near = targets & ~lost & (distance <= search_radius(travel, minimum, SCALE)[view])
    nearest = np.where(near, distance, np.inf).argmin(axis=1)
    found = near.any(axis=1)
    step = (later - now)[view, nearest]
    return xy - np.where(found[:, None], step, 0.0)


def motion_images(P: Array, delay: Array, forecast: Forecast) -> tuple[Array, Array, Array]:
    """Images of T targets in C cameras at the joined time and after the delays, and their travel.

    Returns (C, T, 2) px, (C, T, 2) px and (C, T) px per frame; NaN behind a camera.
    """
    ahead = np.stack([np.zeros_like(delay), delay, np.full_like(delay, -forecast.period)])
    place = forecast.xyz + ahead[..., None, None] * forecast.velocity
    image = place @ P[:, :, :3].swapaxes(1, 2) + P[:, None, :, 3]
    now, later, before = image[..., :2] / np.where(image[..., 2:] > 0, image[..., 2:], np.nan)
    offset = now - before
    return now, later, np.hypot(offset[..., 0], offset[..., 1])
