"""Kernels and weights of the mean-shift fusion (Jin & Qian 2008, section 3.6, eq. 4-8)."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def epipolar_weight(distance: Array, threshold: Array | float) -> Array:
    """Weight exp(-d^2 / (2 T_ED^2)) of the epipolar distance (eq. 8), px; 0 if the distance is NaN."""
    return np.asarray(np.fmax(np.exp(-np.square(distance) / (2 * threshold * threshold)), 0.0))


def scales(bandwidth: Array) -> Array:
    """Weights of squared offsets in :func:`kernel`: (T, 3) m -> (T, 2, 3), 1 / h^2 and 1 / max(h)^2."""
    squares = np.square(bandwidth)
    scale = np.empty((len(bandwidth), 2, 3))
    scale[:, 0] = 1 / squares
    scale[:, 1] = 1 / squares.max(axis=1, keepdims=True)
    return scale


def kernel(offsets: Array, scale: Array, unlabelled: Array) -> Array:
    """Weight by distance from the centre: flat for labelled candidates, truncated Gaussian for the others.

    Inside the ellipsoid with the bandwidth as semi-axes (eq. 5) a labelled candidate weighs 1 (eq. 6), an
    unlabelled one exp(-|x - y|^2 / max(h)^2) (eq. 7); outside, both weigh 0.
    offsets: (T, 3, N) m, candidate minus centre; scale: (T, 2, 3), :func:`scales` of the bandwidths;
    unlabelled: (N,), 1 or 0. Returns (T, N).
    """
    distance2 = scale @ (offsets * offsets)
    weight = np.exp(-unlabelled * distance2[:, 1])
    weight *= distance2[:, 0] < 1.0
    return np.asarray(weight)


def squared_distances(points: Array, centers: Array, scale: Array) -> Array:
    """Sum of s (x - y)^2 over the axes, of all points from all centres, without their offsets.

    points: (N, 3) m; centers: (M, 3) m; scale: (3,) 1/m^2, s. Returns (M, N).
    """
    middle = points.mean(axis=0)  # near the origin the difference of squares loses no digits
    x, y = points - middle, centers - middle
    weighed = y * scale
    distance2 = (-2 * weighed) @ x.T
    distance2 += np.vecdot(weighed, y)[:, None]
    distance2 += (x * x) @ scale
    return np.asarray(distance2)
