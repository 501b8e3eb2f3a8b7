"""The errors of one inertial sensor: constant ones, noise and limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array


@dataclass(frozen=True, eq=False)
class Channel:
    """Three axes of a sensor. bias: (3,); sigma: of the noise of a reading; limit: largest absolute value."""

    bias: Array
    sigma: float
    limit: float = np.inf

    def read(self, true: Array, rng: np.random.Generator) -> Array:
        """Readings of the sensor for true values, both (N, 3)."""
        noisy = true + self.bias + rng.normal(0.0, self.sigma, true.shape)
        return np.asarray(noisy.clip(-self.limit, self.limit))


def channel(rng: np.random.Generator, bias_sigma: float, sigma: float, limit: float = np.inf) -> Channel:
    """A channel whose constant error is drawn with this standard deviation."""
    return Channel(rng.normal(0.0, bias_sigma, 3), sigma, limit)
