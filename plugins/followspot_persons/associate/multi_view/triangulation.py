"""Joints of a body from their points in several pictures, each with its covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.geometry import triangulate_views
from followspot_persons.associate.multi_view.point_errors import OUTLIER
from followspot_persons.associate.multi_view.views import Noise, Views, images, jacobians, rays

STEPS = 4
"""Gauss-Newton steps after the linear start."""
PARALLEL = 1e-6
"""Smallest share of the largest eigenvalue of the normal matrix in the least one."""


@dataclass(frozen=True, eq=False)
class Joints:
    """xyz: (J, 3) m, NaN for joints without a place; covariance: (J, 3, 3) m^2; views: (J,) cameras."""

    xyz: Array
    covariance: Array
    views: Array


def triangulated(views: Views, camera: Array, xy: Array, noise: Noise) -> Joints:
    """The most likely places of J joints in V pictures of one body, those that two cameras found at least.

    camera: (V,); xy: (V, J, 2) px, NaN for joints that were not found. A point's weight falls with its
    squared distance beyond three sigma.
    """
    point = np.swapaxes(xy, 0, 1)
    found = np.asarray(np.isfinite(point).all(axis=-1))
    joints, count = found.sum(axis=1) >= 2, found.sum(axis=1)
    place = np.full((len(point), 3), np.nan)
    covariance = np.full((len(point), 3, 3), np.nan)
    if joints.any():
        place[joints], covariance[joints] = _solved(views, camera, point[joints], found[joints], noise)
    return Joints(place, covariance, np.where(np.isfinite(place).all(axis=1), count, 0))


def _solved(views: Views, camera: Array, point: Array, found: Array, noise: Noise) -> tuple[Array, Array]:
    """Places and covariances of K joints. point: (K, V, 2), found: (K, V)."""
    projection, focal = views.projection[camera], views.focal[camera]
    point = np.where(found[..., None], point, 0.0)
    xyz = triangulate_views(views.center[camera], rays(views.back[camera], point), found.astype(float))
    for _ in range(STEPS):
        there, depth = images(projection, xyz[:, None])
        slope = np.where(found[..., None, None], jacobians(projection, there, depth), 0.0)
        residual = np.where(found[..., None], point - there, 0.0)
        variance = noise.pixel**2 + (focal * noise.body / depth) ** 2
        squared = np.square(residual).sum(axis=-1) / variance
        weight = np.where(found, 1 / (variance * np.maximum(1.0, squared / OUTLIER)), 0.0)
        normal = np.einsum("kv,kvai,kvaj->kij", weight, slope, slope)
        ahead = np.isfinite(normal).all(axis=(1, 2))
        normal[~ahead] = 0.0
        value = np.linalg.eigvalsh(normal)
        sure = ahead & (value[:, 0] > PARALLEL * value[:, 2])
        normal[~sure] = np.eye(3)
        moment = np.einsum("kv,kvai,kva->ki", weight, slope, residual)
        xyz = np.where(sure[:, None], xyz + np.linalg.solve(normal, moment[..., None])[..., 0], np.nan)
    return xyz, np.linalg.inv(normal)
