"""Moments: place and velocity of a tracked target, and its sightings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Room
from followspot.geometry import undistort
from followspot.messages import Array
from followspot_calibrate.tracked import Tracked, frame_interval, in_order, moments_at

REACH = 0.03
"""Largest distance of a blob from the image of its target over the longer side of the picture."""
NEIGHBOURS = 2
"""Moments before and after one that its velocity is taken from."""
GAP = 1.5
"""Frame intervals between two moments from which they are no neighbours."""


@dataclass(frozen=True, eq=False)
class Moments:
    """N moments in the order of targets and times, and C cameras.

    time: (N,) s; target: (N,); xyz: (N, 3) m; xy: (N, C, 2) px, undistorted, NaN if a camera saw nothing;
    late: (N, C) s, by which the camera's time stamp is later than the moment.
    """

    time: Array
    target: Array
    xyz: Array
    xy: Array
    late: Array


def moments(tracked: Tracked, room: Room, offset: Array) -> Moments:
    """Give each blob to the moment of its target that explains it; of several, the nearest counts.

    offset: (C,) s, clock offsets as far as they are known.
    """
    time, target, xyz = in_order(tracked.tracks)
    blobs, cameras = tracked.blobs, list(room.cameras.values())
    moment = moments_at(time, target, blobs)
    known = moment >= 0
    moment, camera = moment[known], blobs.camera[known]
    late = blobs.time[known] - time[moment]
    pixel = undistorted(blobs.pixel[known], camera, room)
    P = np.array([c.projection for c in cameras])
    velocity = velocities(time, target, xyz)[moment]
    place = xyz[moment] + np.nan_to_num(velocity) * (late + offset[camera])[:, None]
    reach = REACH * np.array([max(c.size) for c in cameras])[camera]
    apart = np.linalg.norm(images(P[camera], place) - pixel, axis=1)
    order = np.argsort(-apart, kind="stable")
    order = order[apart[order] < reach[order]]  # the nearest is written last
    xy, delay = np.full((len(time), len(cameras), 2), np.nan), np.zeros((len(time), len(cameras)))
    xy[moment[order], camera[order]] = pixel[order]
    delay[moment[order], camera[order]] = late[order]
    return Moments(time, target, xyz, xy, delay)


def velocities(time: Array, target: Array, xyz: Array) -> Array:
    """Slopes of straight lines through each moment and its neighbours: (N, 3) m/s; NaN if some lack."""
    found = np.full(xyz.shape, np.nan)
    count = 2 * NEIGHBOURS + 1
    rows = np.arange(len(time) - count + 1)[:, None] + np.arange(count)
    if len(rows):
        whole = (target[rows] == target[rows[:, :1]]).all(axis=1)
        whole &= (np.diff(time[rows], axis=1) < GAP * frame_interval(time, target)).all(axis=1)
        rows = rows[whole]
        since = time[rows] - time[rows].mean(axis=1, keepdims=True)
        slope = np.einsum("nk,nki->ni", since, xyz[rows]) / np.square(since).sum(axis=1)[:, None]
        found[rows[:, NEIGHBOURS]] = slope
    return found


def undistorted(pixel: Array, camera: Array, room: Room) -> Array:
    """Points (M, 2) px, each in the camera of that number, without lens distortion."""
    xy = np.empty_like(pixel)
    for number, each in enumerate(room.cameras.values()):
        own = camera == number
        xy[own] = undistort(each, pixel[own])
    return xy


def images(P: Array, xyz: Array) -> Array:
    """Undistorted images: P (..., 3, 4), xyz (..., 3) m -> (..., 2) px; NaN behind the camera."""
    image = (P[..., :3] @ xyz[..., None])[..., 0] + P[..., 3]
    return np.asarray(image[..., :2] / np.where(image[..., 2:] > 0, image[..., 2:], np.nan))
