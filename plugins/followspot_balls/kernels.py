"""Kernels and weights of the mean-shift fusion (Jin & Qian 2008, section 3.6, eq. 4-8)."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def ellipsoid(offsets: Array, bandwidth: Array) -> Array:
    """Q_h: below 0 inside the ellipsoid (eq. 5).

    offsets: (..., 3) m, candidate minus centre; bandwidth: (..., 3) m, its semi-axes. Returns (...,).
    """
    return np.asarray(np.square(offsets / bandwidth).sum(axis=-1) - 1.0)


def flat_kernel(offsets: Array, bandwidth: Array) -> Array:
    """Weight of a labelled candidate: 1 inside the ellipsoid, 0 outside (eq. 6). Shapes as above."""
    return (ellipsoid(offsets, bandwidth) < 0).astype(float)


def truncated_gaussian_kernel(offsets: Array, bandwidth: Array) -> Array:
    """Weight of an unlabelled candidate: exp(-|x - y|^2 / max(h)^2) inside, 0 outside (eq. 7)."""
    distance2 = np.square(offsets).sum(axis=-1)
    gaussian = np.exp(-distance2 / np.square(bandwidth.max(axis=-1)))
    return np.where(ellipsoid(offsets, bandwidth) < 0, gaussian, 0.0)


def epipolar_weight(distance: Array, threshold: float) -> Array:
    """Weight exp(-d^2 / (2 T_ED^2)) of the epipolar distance (eq. 8); px."""
    return np.asarray(np.exp(-np.square(distance) / (2 * threshold * threshold)))


def scales(bandwidth: Array) -> Array:
    """What squares of offsets are weighted with in :func:`kernel`: (T, 3) m -> (T, 3, 2), 1 / h^2 and
    1 / max(h)^2.
    """
    squares = np.square(bandwidth)
    return np.stack([1 / squares, np.broadcast_to(1 / squares.max(axis=1, keepdims=True), squares.shape)], 2)


def kernel(offsets: Array, scale: Array, unlabelled: Array) -> Array:
    """Flat for labelled candidates, truncated Gaussian for the others.

    offsets: (T, N, 3) m; scale: (T, 3, 2), :func:`scales` of the bandwidths; unlabelled: (N,), 1 or 0.
    Returns (T, N).
    """
    distance2 = (offsets * offsets) @ scale
    weight = np.exp(-unlabelled * distance2[..., 1])
    weight *= distance2[..., 0] < 1.0
    return np.asarray(weight)
