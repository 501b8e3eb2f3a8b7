"""Distinct blobs of 3D candidates, in a table of view and slot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.tracking import Candidates


class BlobTable(NamedTuple):
    """Blobs of C cameras, up to K in each; an empty slot is 0 and belongs to no target."""

    xy: Array
    """(C, K, 2) px, undistorted."""
    area: Array
    """(C, K) px, number of pixels."""
    targets: Array
    """(T, C, K) bool: targets that a candidate made of the blob may belong to."""
    clutter_ratio: Array
    """(C, K) density of clutter around each blob over the usual one."""
    slot: Array
    """(N, 2) slots of both blobs of each candidate within their cameras."""


def blob_table(candidates: Candidates, cameras: int) -> BlobTable:
    """The blobs of N > 0 candidates, which may share blobs.

    cameras: of the room, C.
    """
    key = (candidates.view.astype(np.int64) << 32 | candidates.blob).ravel()
    order = key.argsort(kind="stable")
    ascending = key[order]
    new = np.ones(len(key), bool)
    np.not_equal(ascending[1:], ascending[:-1], out=new[1:])
    first = new.nonzero()[0]
    camera = ascending[first] >> 32
    slot_in_view = np.arange(len(first)) - camera.searchsorted(camera)
    shape = (cameras, int(slot_in_view.max()) + 1)
    xy, area, clutter = np.zeros((*shape, 2)), np.zeros(shape), np.ones(shape)
    targets = np.zeros((candidates.targets.shape[1], *shape), bool)
    xy[camera, slot_in_view] = candidates.xy.reshape(-1, 2)[order[first]]
    area[camera, slot_in_view] = candidates.area.reshape(-1)[order[first]]
    clutter[camera, slot_in_view] = candidates.clutter.reshape(-1)[order[first]]
    targets[:, camera, slot_in_view] = np.logical_or.reduceat(candidates.targets[order >> 1], first).T
    slot = np.empty(len(key), int)
    slot[order] = slot_in_view[new.cumsum() - 1]
    return BlobTable(xy, area, targets, clutter, slot.reshape(-1, 2))
