"""How many joints of a new body the cameras agree about."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.associate.multi_view.point_errors import point_sigmas
from followspot_persons.associate.multi_view.views import Noise, Views, images

LARGEST = 3.0
"""Largest mean squared normalised distance, of each degree of freedom, of points that agree."""


def agreement(views: Views, camera: Array, xy: Array, xyz: Array, noise: Noise) -> int:
    """Number of joints about which the cameras agree, less those about which they do not.

    Some joints of different bodies agree by chance, and the others do not. camera: (V,); xy: (V, J, 2) px,
    NaN for joints that were not found; xyz: (J, 3) m, places of the joints by these points.
    """
    there, _ = images(views.projection[camera][:, None], xyz)
    sigma = point_sigmas(views, camera, np.broadcast_to(xyz, (len(camera), *xyz.shape)), noise)
    squared = np.square(xy - there).sum(axis=-1) / sigma**2
    found = np.isfinite(squared)
    freedom = 2 * found.sum(axis=0) - 3
    agrees = np.where(found, squared, 0.0).sum(axis=0) <= LARGEST * freedom
    return int(np.where(agrees, 1, -1)[freedom > 0].sum())  # one camera alone says nothing
