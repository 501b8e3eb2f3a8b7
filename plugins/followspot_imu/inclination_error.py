"""Error of the inclination after the first readings."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_imu.attitude import GRAVITY

FIRST_SPEED = 3.0
"""Sigma of the velocity that a sensor gains while its first readings are averaged, m/s."""
MAXIMUM_SIGMA = 1.0
"""Sigma of the inclination at the first reading, rad."""


def first_inclination(age: Array, time_constant: float) -> Array:
    """Sigma of the remainder of the initial error of the inclination, (N,) rad. age, time_constant: s.

    The mean force over the first readings is upward but for the velocity gained meanwhile, v / t; the filter
    forgets it slowly.
    """
    return np.asarray(
        np.minimum(MAXIMUM_SIGMA, FIRST_SPEED / (GRAVITY * age)) * np.exp(-age / (2 * time_constant))
    )
