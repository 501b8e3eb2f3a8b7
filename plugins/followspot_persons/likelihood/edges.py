"""The likelihood of a picture's edges given the outline of a body (Weinrich et al. 2010, section 3.2)."""

from __future__ import annotations

from functools import cache

import numpy as np

from followspot import Array

UNITS = 256
"""Sigma of the orientation, in pi."""


@cache
def agreement(sigma: float) -> Array:
    """Gaussian of a difference of orientations, modulo pi, as a table: (256,) float32 for pi/256 each.

    sigma: rad. The entry of difference 0 is 1 / 255, so that it turns magnitudes of 0 to 255 into 0 to 1.
    """
    difference = np.arange(UNITS) * np.pi / UNITS
    difference = np.minimum(difference, np.pi - difference)
    return np.asarray(np.exp(-0.5 * (difference / sigma) ** 2) / 255, np.float32)


def edge_likelihood(magnitude: Array, orientation: Array, expected: Array, sigma: float) -> Array:
    """F^E: mean over the edge features of magnitude times Gaussian of the difference in orientation.

    magnitude, orientation: (P, E) u1, the picture's at the features of P bodies, as in `Gradients`; a
    feature outside the picture has magnitude 0; expected: (P, E) or (E,) rad; sigma: rad.
    Returns (P,), 0 to 1.
    """
    units = np.rint(expected * (UNITS / np.pi)).astype(np.int16)
    fit = agreement(sigma).take((orientation - units) & (UNITS - 1))
    return np.asarray((fit * magnitude).mean(axis=1))
