"""Bodies that boxes measure, for tests."""

from __future__ import annotations

import numpy as np

from followspot_persons.associate.boxes.ellipsoid import SIZE
from followspot_persons.associate.boxes.shape_mixture import NEW, SHAPES, ShapeMixture


def standing(*xy: tuple[float, float]) -> ShapeMixture:
    """People at these places, m, known to some centimetres."""
    state, covariance = np.zeros((len(xy), 2, SIZE)), np.zeros((len(xy), 2, SIZE, SIZE))
    state[..., :2], state[..., 2] = np.array(xy)[:, None], 0.86
    for number, shape in enumerate(SHAPES):
        state[:, number, 6:] = shape.mean
        sigmas = np.append([0.1, 0.1, 0.05, 0.3, 0.3, 0.1], 0.5 * shape.sigma)
        covariance[:, number] = np.diag(sigmas**2)
    return ShapeMixture(state, covariance, np.tile(NEW, (len(xy), 1)), np.zeros(len(xy), int))
