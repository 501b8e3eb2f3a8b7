"""Position from one view: the forecast or a plane determines the depth."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from followspot.messages import Array
from followspot_balls.scene.bounding_planes import nearest_planes

FORECAST_SIGMA = 1.0
"""Sigma of the forecast, m: large, because it only has to fix the depth; the filter weighs the forecast
itself."""
PLANE_SIGMA = 0.01
"""One sigma of the height of a ball that lies on a plane, m."""
MAXIMUM_DEVIATION = 0.08
"""Deviation from its steady motion beyond which a ball that rolled may be anywhere on the ray, m."""
RISING_SPEED = 0.15
"""Speed away from a plane beyond which a ball does not lie on it, m/s: 99 % of the estimates of balls at rest
are smaller, at 20 to 60 frames a second."""


class Innovations(NamedTuple):
    """Blobs relative to the projections of forecasts."""

    offset: Array
    """(..., 2) px, from the forecast's projection to the blob."""
    jacobian: Array
    """(..., 2, 3) px/m, of the projection by the position."""

    def where(self, rows: Any) -> Innovations:
        """The innovations that a mask or an index selects."""
        return Innovations(self.offset[rows], self.jacobian[rows])


def projections(P: Array, xyz: Array) -> tuple[Array, Array]:
    """Projections of points into C views, and their Jacobians.

    P: (C, 3, 4); xyz: (C, T, 3) m. Returns (C, T, 2) px, NaN behind the camera, and (C, T, 2, 3) px/m.
    """
    image = xyz @ P[:, :, :3].swapaxes(1, 2) + P[:, None, :, 3]
    depth = np.where(image[..., 2:] > 0, image[..., 2:], np.nan)
    pixel = image[..., :2] / depth
    jacobian = P[:, None, :2, :3] - pixel[..., None] * P[:, None, 2:, :3]
    return pixel, jacobian / depth[..., None]


def normalized_squares(innovations: Innovations, covariance: Array, sigma: float) -> Array:
    """Normalised innovations squared of blobs (Bar-Shalom): (N, T), NaN behind the camera.

    innovations: (N, T); covariance: (T, 3, 3) m^2, of the forecasts; sigma: of a blob's centre, px.
    """
    spread = innovations.jacobian @ covariance @ innovations.jacobian.swapaxes(-1, -2) + np.eye(2) * sigma**2
    a, b, d = spread[..., 0, 0], spread[..., 0, 1], spread[..., 1, 1]
    x, y = innovations.offset[..., 0], innovations.offset[..., 1]
    return np.asarray((d * x * x - 2 * b * x * y + a * y * y) / (a * d - b * b))


class BallStates(NamedTuple):
    """Predicted states of M balls."""

    xyz: Array
    """(M, 3) m."""
    velocity: Array
    """(M, 3) m/s."""
    covariance: Array
    """(M, 3, 3) m^2, of the position."""


def supporting_planes(ball: BallStates, radius: Array, planes: Array, reach: float) -> tuple[Array, Array]:
    """The nearest planes of balls that lie on one: normals (M, 3), zero for others, and clearances (M,) m.

    A ball that rises was picked up, and a forecast that is vague along the normal does not say that it lies.
    radius: (M,) m; planes: (K, 4); reach: clearance up to which a ball lies on a plane, and half of the
    largest sigma of it, m.
    """
    if not len(planes):
        return np.zeros(ball.xyz.shape), np.zeros(len(ball.xyz))
    normal, clearance = nearest_planes(planes, ball.xyz, radius)
    variance = np.vecdot(normal, (ball.covariance @ normal[..., None])[..., 0])
    lying = (np.abs(clearance) <= reach) & (variance <= (2 * reach) ** 2)
    lying &= np.vecdot(ball.velocity, normal) <= RISING_SPEED
    return normal * lying[:, None], clearance


def most_likely_positions(
    xyz: Array, innovations: Innovations, support: tuple[Array, Array], sigma: float
) -> tuple[Array, Array]:
    """The most likely positions of balls that one view sees, linearised at their forecasts.

    xyz: (M, 3) m, forecasts; innovations: of M blobs; support: normals and clearances of the planes that the
    balls lie on, from :func:`supporting_planes`; sigma: of a blob's centre, px. Returns (M, 3) m and
    covariances (M, 3, 3) m^2.
    """
    normal, clearance = support
    design = np.concatenate([innovations.jacobian / sigma, normal[:, None] / PLANE_SIGMA], axis=1)
    residual = np.concatenate([innovations.offset / sigma, -clearance[:, None] / PLANE_SIGMA], axis=1)
    transposed = design.swapaxes(1, 2)
    covariance = np.linalg.inv(transposed @ design + np.eye(3) / FORECAST_SIGMA**2)
    return xyz + (covariance @ transposed @ residual[..., None])[..., 0], covariance
