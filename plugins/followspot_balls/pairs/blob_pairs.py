"""The blobs of all cameras of one frame, pairs of them, and which pairs are projections."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot_balls.detection.strip import row_and_column


class GatheredBlobs(NamedTuple):
    """The N blobs of all cameras of one frame, those of each view in turn."""

    view: Array
    """(N,) numbers of the cameras, ascending."""
    row: Array
    """(N,) numbers within the messages."""
    xy: Array
    """(N, 2) px, at the time of the joined messages."""
    area: Array
    """(N,) px."""
    targets: Array
    """(N, T) bool, which each may be."""
    clutter: Array
    """(N,) share of the usual clutter around each."""
    both_kinds: bool
    """Whether cameras of both kinds have sent blobs, now or before."""


class NearPairs(NamedTuple):
    """M pairs of blobs near their epipolar lines."""

    pair: Array
    """(M, 2) numbers of the blobs."""
    cameras: Array
    """(M, 2) numbers."""
    ends: Array
    """(M, 2, 2) px, places of the two blobs."""
    distance: Array
    """(M,) px, from the epipolar lines."""
    order: Array
    """(M,) numbers of the two cameras among all ordered pairs of them."""
    color: Array
    """(M, 2) bool, which are blobs of colour cameras."""

    def where(self, keep: Array) -> NearPairs:
        """Some of the pairs; these themselves if all are kept, as in most frames. keep: (M,) bool."""
        rows = keep.nonzero()[0]
        return self if len(rows) == len(keep) else NearPairs(*(column.take(rows, axis=0) for column in self))


def candidate_pairs(view: Array, targets: Array) -> Array:
    """All pairs of blobs in different views that may belong to one target: (M, 2), the first view lower.

    view: (N,) ascending; targets: (N, T) bool.
    """
    weights = targets.astype(np.float32)
    common = (weights @ weights.T > 0) & (view[:, None] < view)
    return np.array(row_and_column(common.reshape(-1).nonzero()[0], len(view))).T


def common_targets(targets: Array, pair: Array) -> Array:
    """The targets that both blobs of pairs may be: (N, T) bool of blobs, (M, 2) -> (M, T) bool."""
    return np.asarray(targets.take(pair[:, 0], axis=0) & targets.take(pair[:, 1], axis=0))


def homography_test(pair: Array, color: Array, on_plane: Array, blobs: int) -> Array:
    """Which pairs are no projections.

    A pair on a plane is one, unless a colour blob of it is in list B of that plane: the colour blobs
    of colour-infrared pairs that satisfy the plane too, for an infrared camera sees no projection, so
    there the ball itself lies on the plane.
    pair: (M, 2) numbers of blobs, of `blobs`; color: (M, 2) bool; on_plane: (planes, M) bool. Returns (M,).
    """
    both = color[:, 0] & color[:, 1]
    listed = np.zeros((len(on_plane), blobs), bool)
    plane, row = (on_plane & (color[:, 0] != color[:, 1])).nonzero()
    listed[plane, pair.take(row, axis=0)[color.take(row, axis=0)]] = True
    excused = listed.take(pair[:, 0], axis=1) | listed.take(pair[:, 1], axis=1)
    return np.asarray(~((on_plane & ~excused).any(axis=0) & both))
