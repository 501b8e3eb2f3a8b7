"""Tracks of points shifted in time: interpolated sightings a little earlier or later."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot_calibrate.sightings import Sightings

GAP = 1.5
"""Steps between two sightings from which on nothing is known of what lies between them."""


def resampled(sightings: Sightings, late: Array) -> Array:
    """Pixels as if all cameras had taken their pictures at the moments of the frames: (N, C, 2) px.

    late: (C,) frames by which a camera's pictures were taken later. Between two sightings the track is
    straight; NaN if it has a gap or ends.
    """
    pixel, step = sightings.pixel.copy(), frame_step(sightings)
    for label in np.unique(sightings.label):
        rows = np.flatnonzero(sightings.label == label)
        rows = rows[np.argsort(sightings.frame[rows], kind="stable")]
        frame = sightings.frame[rows].astype(float)
        for camera in np.flatnonzero(late):
            track = sightings.pixel[rows, camera]
            pixel[rows, camera] = _at(frame - late[camera], frame, track, GAP * step)
    return pixel


def frame_step(sightings: Sightings) -> float:
    """Median distance between successive frames of the file, from 1."""
    steps = np.diff(np.unique(sightings.frame))
    return float(np.median(steps)) if len(steps) else 1.0


def _at(wanted: Array, frame: Array, track: Array, gap: float) -> Array:
    """A track (M, 2) of ascending frames (M,) at other moments; NaN across gaps."""
    before = np.searchsorted(frame, wanted, side="right") - 1
    inside = (before >= 0) & (wanted <= frame[-1])
    before = np.clip(before, 0, len(frame) - 1)
    after = np.minimum(before + 1, len(frame) - 1)
    apart = frame[after] - frame[before]
    share = (wanted - frame[before]) / np.maximum(apart, 1.0)
    exact = share == 0
    between = (1 - share)[:, None] * track[before] + share[:, None] * track[after]
    found = np.where(exact[:, None], track[before], between)
    return np.where((inside & (exact | (apart < gap)))[:, None], found, np.nan)
