"""Position from one view: the forecast or a plane determines the depth."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from followspot.messages import Array
from followspot_balls.scene.bounding_planes import nearest_planes

OPEN = 1.0
"""Sigma of the forecast, m: large, because it only has to fix the depth; the filter weighs the forecast
itself."""
PLANE = 0.01
"""One sigma of the height of a ball that lies on a plane, m."""
COURSE = 0.08
"""Distance from its course beyond which a ball that rolled on a plane may be anywhere on the ray, m."""
RISING = 0.15
"""Speed away from a plane beyond which a ball does not lie on it, m/s: 99 % of the estimates of balls at rest
are smaller, at 20 to 60 frames a second."""


class Sight(NamedTuple):
    """Blobs relative to the images of forecasts."""

    offset: Array
    """(..., 2) px, from the forecast's image to the blob."""
    slope: Array
    """(..., 2, 3) px/m, derivative of the image by the place."""

    def where(self, rows: Any) -> Sight:
        """The sights that a mask or an index selects."""
        return Sight(self.offset[rows], self.slope[rows])


def images(P: Array, place: Array) -> tuple[Array, Array]:
    """Images of places in C views and their derivatives.

    P: (C, 3, 4); place: (C, T, 3) m. Returns (C, T, 2) px, NaN behind the camera, and (C, T, 2, 3) px/m.
    """
    image = place @ P[:, :, :3].swapaxes(1, 2) + P[:, None, :, 3]
    depth = np.where(image[..., 2:] > 0, image[..., 2:], np.nan)
    pixel = image[..., :2] / depth
    slope = P[:, None, :2, :3] - pixel[..., None] * P[:, None, 2:, :3]
    return pixel, slope / depth[..., None]


def misfit(sight: Sight, covariance: Array, sigma: float) -> Array:
    """Squared Mahalanobis distances of blobs from forecasts: of (N, T) sights, NaN if there is no image.

    covariance: (T, 3, 3) m^2, of the forecasts; sigma: of a blob's place, px.
    """
    spread = sight.slope @ covariance @ sight.slope.swapaxes(-1, -2) + np.eye(2) * sigma**2
    a, b, d = spread[..., 0, 0], spread[..., 0, 1], spread[..., 1, 1]
    x, y = sight.offset[..., 0], sight.offset[..., 1]
    return np.asarray((d * x * x - 2 * b * x * y + a * y * y) / (a * d - b * b))


class Motions(NamedTuple):
    """Forecasts of M balls."""

    place: Array
    """(M, 3) m."""
    velocity: Array
    """(M, 3) m/s."""
    covariance: Array
    """(M, 3, 3) m^2, of the place."""


def resting(ball: Motions, radius: Array, planes: Array, reach: float) -> tuple[Array, Array]:
    """The nearest planes of balls that lie on one: normals (M, 3), zero for others, and clearances (M,) m.

    A ball that rises was picked up, and a forecast that is vague along the normal does not say that it lies.
    radius: (M,) m; planes: (K, 4); reach: clearance up to which a ball lies on a plane, and half of the
    largest sigma of it, m.
    """
    if not len(planes):
        return np.zeros(ball.place.shape), np.zeros(len(ball.place))
    normal, clearance = nearest_planes(planes, ball.place, radius)
    variance = np.vecdot(normal, (ball.covariance @ normal[..., None])[..., 0])
    lying = (np.abs(clearance) <= reach) & (variance <= (2 * reach) ** 2)
    lying &= np.vecdot(ball.velocity, normal) <= RISING
    return normal * lying[:, None], clearance


def settled(place: Array, sight: Sight, lying: tuple[Array, Array], sigma: float) -> tuple[Array, Array]:
    """The most likely places of balls that one view sees, linearised at their forecasts.

    place: (M, 3) m, forecasts; sight: M blobs; lying: normals and clearances of the planes that they lie
    on, as of :func:`resting`; sigma: of a blob's place, px. Returns (M, 3) m and covariances (M, 3, 3) m^2.
    """
    normal, clearance = lying
    design = np.concatenate([sight.slope / sigma, normal[:, None] / PLANE], axis=1)
    wanted = np.concatenate([sight.offset / sigma, -clearance[:, None] / PLANE], axis=1)
    across = design.swapaxes(1, 2)
    covariance = np.linalg.inv(across @ design + np.eye(3) / OPEN**2)
    return place + (covariance @ across @ wanted[..., None])[..., 0], covariance
