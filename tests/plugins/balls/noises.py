"""Random covariances of positions."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array


def noises(rng: np.random.Generator, count: int, finest: float, coarsest: float) -> Array:
    """Covariances of positions along any axes, (count, 3, 3) m^2; one sigma along each between these, m."""
    axes = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    sigma = np.exp(rng.uniform(np.log(finest), np.log(coarsest), (count, 3)))
    found = (axes * sigma[:, None] ** 2) @ axes.swapaxes(1, 2)
    return np.asarray((found + found.swapaxes(1, 2)) / 2)
