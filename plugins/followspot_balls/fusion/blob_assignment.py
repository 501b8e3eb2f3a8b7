"""Assignment of blobs to targets: at most one target for each blob."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot_balls.measurement.points import BEHIND, Images

RESERVED = 9.0
"""Squared distance from a tracked target up to which it keeps a blob from a lost one, px^2: half a ball."""


class Claims(NamedTuple):
    """Blobs of C cameras, K slots each, that M targets compete for."""

    xy: Array
    """(C, K, 2) px, undistorted."""
    possible: Array
    """(M, C, K) bool: whether the blob may show the target."""
    sizes: Array
    """(C, K) area over that of a ball of unit radius at unit depth."""
    radius: Array
    """(M,) m."""
    lost: Array
    """(M,) bool: without forecast."""


def shares(claims: Claims, depth: Array, row: Array, slot: Array | None = None) -> Array:
    """Share of the targets' outlines that blobs show: sizes (C, K) at depths (H, C) m of targets (H,).

    slot: (H, C), for one blob in each view. Returns (H, C, K), or (H, C).
    """
    scale = np.square(depth / claims.radius[row][:, None])
    if slot is None:
        return np.asarray(claims.sizes * scale[..., None])
    return np.asarray(claims.sizes[np.arange(len(claims.sizes)), slot] * scale)


def squared_errors(xy: Array, seen: Images, possible: Array) -> Array:
    """Squared distances of blobs from images, px^2: (C, K, 2) -> (H, C, K); inf if not `possible`."""
    across, down = xy[..., 0] - seen.xy[..., 0, None], xy[..., 1] - seen.xy[..., 1, None]
    squares = across * across + down * down
    return np.where(possible & (seen.depth > BEHIND)[..., None], squares, np.inf)


def assigned(claims: Claims, seen: Images) -> tuple[Array, Array]:
    """The nearest blob of each target in each view that is nearer to no other target.

    Tracked targets take precedence: a lost one gets only blobs that are far from all of them.
    seen: of the M targets. Returns slots (M, C) and whether there is such a blob, (M, C) bool.
    """
    squares = squared_errors(claims.xy, seen, claims.possible)
    rivalry = squares + RESERVED * claims.lost[:, None, None]
    own = np.where(rivalry <= rivalry.min(axis=0), squares, np.inf)
    return own.argmin(axis=2), np.isfinite(own.min(axis=2, initial=np.inf))
