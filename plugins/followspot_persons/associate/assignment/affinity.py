"""Whether two detections of different cameras are one body, by their points' epipolar distances."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from followspot import Array
from followspot.geometry import epipolar_distance, triangulate_pairs
from followspot_persons.associate.multi_view.point_errors import INDEPENDENT, WRONG, point_sigmas
from followspot_persons.associate.multi_view.views import Noise, Views, rays

ANYWHERE = 1000.0
"""Distance from an epipolar line within which points of other bodies are, px."""
LARGEST, SMALLEST = 0.8, 0.08
"""Root mean square distance of a body's points from their middle, m."""


def is_body(xyz: Array, largest: float = LARGEST) -> Array:
    """(P,) whether points (P, J, 3) m, two at least, are as far apart as a body's."""
    there = np.asarray(np.isfinite(xyz).all(axis=-1))
    number = np.maximum(there.sum(axis=1), 1)
    known = np.where(there[..., None], xyz, 0.0)
    middle = known.sum(axis=1) / number[:, None]
    squared = np.where(there, np.square(known - middle[:, None]).sum(axis=-1), 0.0)
    size = np.sqrt(squared.sum(axis=1) / number)
    return np.asarray((there.sum(axis=1) >= 2) & (size < largest) & (size > SMALLEST))


def pair_ratios(
    views: Views, camera: Array, xy: Array, noise: Noise, possible: Callable[[Array], Array] = is_body
) -> Array:
    """Log-likelihood ratios of two detections being one body against two, (N, N); -inf within a camera.

    camera: (N,); xy: (N, J, 2) px, NaN for points that were not found; possible: says of P pairs whether they
    may be a body, (P,) bool, by their points (P, J, 3) m.
    """
    count = len(camera)
    ratio = np.full((count, count), -np.inf)
    a, b = np.triu_indices(count, 1)
    apart = camera[a] != camera[b]
    a, b = a[apart], b[apart]
    if not len(a):
        return ratio
    F = views.fundamental[camera[a], camera[b]][:, None]
    distance = epipolar_distance(F, xy[a], xy[b])
    xyz = points_between(views, camera, xy, a, b)
    sigma = np.hypot(point_sigmas(views, camera[a], xyz, noise), point_sigmas(views, camera[b], xyz, noise))
    density = np.exp(-0.5 * (distance / sigma) ** 2) / (np.sqrt(2 * np.pi) * sigma)
    each = np.log((1 - WRONG) * ANYWHERE * density + WRONG)
    shared = np.isfinite(xy[a, :, 0]) & np.isfinite(xy[b, :, 0])
    each = np.where(np.isfinite(each), each, np.log(WRONG))
    number = shared.sum(axis=1)
    mean = np.where(shared, each, 0.0).sum(axis=1) / np.maximum(number, 1)
    found = mean * np.minimum(number, INDEPENDENT)
    ratio[a, b] = ratio[b, a] = np.where(possible(xyz), found, -np.inf)
    return ratio


def points_between(views: Views, camera: Array, xy: Array, a: Array, b: Array) -> Array:
    """Points between the rays of the pairs, (P, J, 3) m; NaN if they do not meet."""
    direction = rays(views.back[camera][:, None], xy)
    center = np.broadcast_to(views.center[camera][:, None], direction.shape)
    centers = np.stack([center[a], center[b]], axis=2).reshape(-1, 2, 3)
    directions = np.stack([direction[a], direction[b]], axis=2).reshape(-1, 2, 3)
    return triangulate_pairs(centers, directions).reshape(len(a), xy.shape[1], 3)
