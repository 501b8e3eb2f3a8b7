"""The blobs behind 3D candidates, each once, in a table of camera and slot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates


class Sightings(NamedTuple):
    """Blobs of C cameras, up to K in each; an empty slot is 0 and no target's."""

    xy: Array
    """(C, K, 2) px, undistorted."""
    area: Array
    """(C, K) px, number of pixels."""
    targets: Array
    """(T, C, K) bool: targets that a candidate made of the blob may belong to."""
    slot: Array
    """(N, 2) slots of both blobs of each candidate within their cameras."""


def sightings(candidates: Candidates, cameras: int) -> Sightings:
    """Collect the blobs that N candidates were made of; a blob takes part in several of them.

    cameras: of the room, C.
    """
    ends = candidates.view.size
    key = (candidates.view.astype(np.int64) << 32 | candidates.blob).ravel()
    order = key.argsort(kind="stable")
    ascending = key[order]
    first = np.flatnonzero(np.diff(ascending, prepend=-1))
    camera = ascending[first] >> 32
    place = np.arange(len(first)) - np.searchsorted(camera, camera)
    shape = (cameras, int(place.max(initial=-1)) + 1)
    xy = np.zeros((*shape, 2))
    area = np.zeros(shape)
    targets = np.zeros((candidates.targets.shape[1], *shape), bool)
    slot = np.zeros(ends, int)
    if ends:
        xy[camera, place] = candidates.xy.reshape(-1, 2)[order[first]]
        area[camera, place] = candidates.area.reshape(-1)[order[first]]
        targets[:, camera, place] = np.logical_or.reduceat(candidates.targets[order >> 1], first).T
        slot[order] = np.repeat(place, np.diff(first, append=ends))
    return Sightings(xy, area, targets, slot.reshape(-1, 2))
