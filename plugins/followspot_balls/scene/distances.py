"""Distances of points from places in the room."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def squared_distances(places: Array, points: Array) -> Array:
    """Squared distances of all points from all places: (M, 3) m and (N, 3) m -> (M, N) m^2."""
    off = np.ascontiguousarray(points.T) - places[..., None]  # long rows are computed faster
    off *= off
    return np.asarray(off.sum(axis=1))
