"""Motion model of bodies: their velocity decays and is driven by noise, an Ornstein-Uhlenbeck process.

It is the first-order Markov model of Bar-Shalom, Li & Kirubarajan 2001, section 8.2, one derivative lower.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array


class Step(NamedTuple):
    """Prediction: velocity is multiplied by `fade`, its share `reach`, s, is added to the position;
    position, cross, velocity: added variances and covariance, per axis, m^2, m^2/s, m^2/s^2.
    """

    fade: Array
    reach: Array
    position: Array
    cross: Array
    velocity: Array


def step(seconds: float | Array, sigma: Array, memory: Array) -> Step:
    """sigma: of velocities in the long run, m/s; memory: time constant of their decay, s. Any equal
    shapes.
    """
    fade = np.exp(-seconds / memory)
    variance = sigma**2
    return Step(
        fade,
        memory * (1 - fade),
        variance * np.maximum(2 * memory * seconds - memory**2 * (3 - 4 * fade + fade**2), 0.0),
        variance * memory * (1 - fade) ** 2,
        variance * (1 - fade**2),
    )
