"""Covariance of a robust fit for the case that the views which it rejected are right."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot_balls.measurement.points import PARAMETERS

FLAT = 1e-9
"""Smallest determinant of J J^T of a view, px^4/m^4, that is divided by."""


def contradicted(design: Array, step: Array, trust: Array, found: Array, exponent: float) -> Array:
    """What rejected views add to the covariances of M places: (M, 3, 3) m^2.

    A view that kept a share t of its weight is rejected with 1 - t. The covariance is the spread of the
    places that rejected views ask for, each the nearest on its ray, times the probability r^k / (t^k + r^k)
    that they are right, with the sums t and r over all views: as in a mixture of both (Bar-Shalom, Li &
    Kirubarajan 2001, section 1.4.16). It is at most a half, because the fit began where most votes were.
    design: (M, 2C, 5), see :func:`measurement.points.linearised`; step: (M, 4); trust: (M, C); found: (M, C)
    bool, views that have a blob; exponent: k.
    """
    rejected = found * (1 - trust)
    against = rejected.sum(axis=1)
    odds = np.minimum(against / np.maximum(trust.sum(axis=1), FLAT), 1.0) ** exponent
    errors = design[..., PARAMETERS] - (design[..., :PARAMETERS] @ step[..., None])[..., 0]
    off = nearest_shifts(design[..., :3].reshape(*trust.shape, 2, 3), errors.reshape(*trust.shape, 2))
    spread = (off * rejected[..., None]).swapaxes(1, 2) @ off
    return np.asarray(spread * (odds / (1 + odds) / np.maximum(against, FLAT))[:, None, None])


def nearest_shifts(jacobian: Array, errors: Array) -> Array:
    """Smallest shifts that cause errors, J^T (J J^T)^-1 e: (..., 2, 3) px/m, (..., 2) px -> (..., 3) m."""
    across, down = jacobian[..., 0, :], jacobian[..., 1, :]
    a, b, d = np.vecdot(across, across), np.vecdot(across, down), np.vecdot(down, down)
    u, v = errors[..., 0], errors[..., 1]
    scale = 1 / np.maximum(a * d - b * b, FLAT)
    return np.asarray(
        ((d * u - b * v) * scale)[..., None] * across + ((a * v - b * u) * scale)[..., None] * down
    )
