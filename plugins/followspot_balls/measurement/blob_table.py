"""The distinct blobs of 3D candidates, in a table of camera and slot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates


class Sightings(NamedTuple):
    """Blobs of C cameras, up to K in each; an empty slot is 0 and belongs to no target."""

    xy: Array
    """(C, K, 2) px, undistorted."""
    area: Array
    """(C, K) px, number of pixels."""
    targets: Array
    """(T, C, K) bool: targets that a candidate made of the blob may belong to."""
    clutter: Array
    """(C, K) share of the usual clutter around each blob."""
    slot: Array
    """(N, 2) slots of both blobs of each candidate within their cameras."""


def sightings(candidates: Candidates, cameras: int) -> Sightings:
    """Collect the blobs of N > 0 candidates, which may share blobs.

    cameras: of the room, C.
    """
    key = (candidates.view.astype(np.int64) << 32 | candidates.blob).ravel()
    order = key.argsort(kind="stable")
    ascending = key[order]
    new = np.ones(len(key), bool)
    np.not_equal(ascending[1:], ascending[:-1], out=new[1:])
    first = new.nonzero()[0]
    camera = ascending[first] >> 32
    place = np.arange(len(first)) - camera.searchsorted(camera)
    shape = (cameras, int(place.max()) + 1)
    xy, area, clutter = np.zeros((*shape, 2)), np.zeros(shape), np.ones(shape)
    targets = np.zeros((candidates.targets.shape[1], *shape), bool)
    xy[camera, place] = candidates.xy.reshape(-1, 2)[order[first]]
    area[camera, place] = candidates.area.reshape(-1)[order[first]]
    clutter[camera, place] = candidates.clutter.reshape(-1)[order[first]]
    targets[:, camera, place] = np.logical_or.reduceat(candidates.targets[order >> 1], first).T
    slot = np.empty(len(key), int)
    slot[order] = place[new.cumsum() - 1]
    return Sightings(xy, area, targets, clutter, slot.reshape(-1, 2))
