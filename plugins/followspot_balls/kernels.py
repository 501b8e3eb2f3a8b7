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


def kernel(offsets: Array, bandwidth: Array, labelled: Array) -> Array:
    """Flat for labelled candidates, truncated Gaussian for the others.

    offsets: (T, N, 3) m; bandwidth: (T, 3) m; labelled: (N,) bool. Returns (T, N).
    """
    squares = np.square(offsets)
    inside = np.einsum("tni,ti->tn", squares, 1 / np.square(bandwidth)) < 1.0
    widest = np.square(bandwidth.max(axis=1))[:, None]
    return np.asarray(np.where(labelled, 1.0, np.exp(-squares.sum(axis=2) / widest)) * inside)
