"""Errors of the points that networks find in pictures."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.associate.multi_view.views import Noise, Views

WRONG = 0.1
"""Share of a network's points that are anywhere."""
INDEPENDENT = 4
"""Points of a body whose errors are independent: more of them are no more evidence."""
OUTLIER = 9.0
"""Squared normalised distance above which a point's variance grows with it: a bound on its influence."""
WALKING = 1.0
"""Speed that times of exposure count with, m/s."""


def point_sigmas(views: Views, camera: Array, xyz: Array, noise: Noise) -> Array:
    """Sigma of the points of a camera, (P, J) px, at these places (P, J, 3) m. camera: (P,)."""
    depth = np.linalg.norm(xyz - views.center[camera][:, None], axis=-1)
    body = np.hypot(noise.body, WALKING * noise.delay)
    return np.asarray(np.hypot(noise.pixel, views.focal[camera][:, None] * body / depth))
