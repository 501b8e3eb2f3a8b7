"""Points that several views see: maximum likelihood by robust Gauss-Newton (H&Z, chapter 4 and appendix 6).

A point has four parameters: its place, m, and its glow, m: how far along the normal of a plane the
light that a glowing ball throws on that plane draws its centre in colour cameras.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot.messages import Array

PARAMETERS = 4
BEHIND = 1e-6
"""Depth of all points behind the camera, m."""


class Images(NamedTuple):
    """Images of points."""

    xy: Array
    """(M, C, 2) px, undistorted."""
    depth: Array
    """(M, C) m; BEHIND for points that have no image."""


class Projection(NamedTuple):
    """The projection of M points into C views: x ~ matrix p + offset for parameters p."""

    matrix: Array
    """(M, C, 3, 4)."""
    offset: Array
    """(C, 3)."""


class Belief(NamedTuple):
    """Prior knowledge of the parameters: Gaussians in canonical form, so that independent ones add up."""

    vector: Array
    """(M, 4), information times mean."""
    information: Array
    """(M, 4, 4), the inverse of the covariance; 0 if nothing is known."""

    def and_also(self, other: Belief) -> Belief:
        """The product of two independent beliefs."""
        return Belief(self.vector + other.vector, self.information + other.information)

    def relative(self, origin: Array) -> Belief:
        """The belief about the step from an origin (M, 4)."""
        return self._replace(vector=self.vector - (self.information @ origin[..., None])[..., 0])


def empty_belief(count: int) -> Belief:
    """An uninformative belief about `count` points."""
    return Belief(np.zeros((count, PARAMETERS)), np.zeros((count, PARAMETERS, PARAMETERS)))


class Views(NamedTuple):
    """One blob for each point and view."""

    xy: Array
    """(M, C, 2) px; any number if there is none."""
    precision: Array
    """(M, C) 1/px^2, inverse variance along each axis; 0 if there is none."""
    cutoff2: Array
    """(M, C) px^2, square of the error at which a view keeps a quarter of its weight."""


class Equations(NamedTuple):
    """Weighted normal equations of a step d from the linearisation point: normal d = right."""

    normal: Array
    """(M, 4, 4)."""
    right: Array
    """(M, 4)."""
    trust: Array
    """(M, C) robust weight of each view, 1 for one that fits, 0 if there is none."""
    cost: Array
    """(M,) sum of weighted squared errors."""


def glowing_projection(P: Array, normal: Array, color: Array) -> Projection:
    """The projection of points whose images in colour cameras are shifted by their glow along a normal.

    P: (C, 3, 4); normal: (M, 3); color: (C,) bool.
    """
    matrix = np.empty((len(normal), len(P), 3, PARAMETERS))
    matrix[..., :3] = P[:, :, :3]
    matrix[..., 3] = (P[:, :, :3] @ normal[:, None, :, None])[..., 0] * color[:, None]
    return Projection(matrix, P[:, :, 3])


def images(projection: Projection, parameters: Array) -> Images:
    """(M, 4) -> images in all views."""
    x = (projection.matrix @ parameters[:, None, :, None])[..., 0] + projection.offset
    return _flattened(x)


def point_images(P: Array, xyz: Array) -> Images:
    """Images of points without glow: (C, 3, 4), (M, 3) m."""
    return _flattened((xyz @ P[:, :, :3].reshape(-1, 3).T).reshape(len(xyz), len(P), 3) + P[:, :, 3])


def _flattened(x: Array) -> Images:
    depth = np.maximum(x[..., 2], BEHIND)
    return Images(x[..., :2] / depth[..., None], depth)


def linearised(projection: Projection, seen: Images, views: Views) -> Array:
    """Jacobian of the images and, in a last column, the errors of the views: (M, 2C, 5), px."""
    A = projection.matrix
    design = np.empty((*A.shape[:2], 2, PARAMETERS + 1))
    design[..., :PARAMETERS] = A[:, :, :2] - seen.xy[..., None] * A[:, :, 2:]
    design[..., :PARAMETERS] /= seen.depth[..., None, None]
    design[..., PARAMETERS] = views.xy - seen.xy
    return design.reshape(len(A), -1, PARAMETERS + 1)


def weighted(design: Array, step: Array, views: Views) -> Equations:
    """Normal equations with the weights of Geman and McClure, (1 + e^2 / c^2)^-2, after a step.

    design: see :func:`linearised`; step: (M, 4).
    """
    J, errors = design[..., :PARAMETERS], design[..., PARAMETERS]
    left = errors - (J @ step[..., None])[..., 0]
    squares = np.square(left).reshape(*views.precision.shape, 2).sum(axis=2)
    trust = np.square(views.cutoff2 / (views.cutoff2 + squares)) * (views.precision > 0)
    weight = trust * views.precision
    both = np.repeat(weight, 2, axis=1)
    system = (J * both[..., None]).swapaxes(1, 2) @ design
    cost = np.einsum("mc,mc->m", weight, squares)
    return Equations(system[..., :PARAMETERS], system[..., PARAMETERS], trust, cost)


def solved(equations: Equations, belief: Belief) -> Array:
    """The step (M, 4) to the maximum of views and belief together; the belief is about the step."""
    right = equations.right + belief.vector
    return np.asarray(np.linalg.solve(equations.normal + belief.information, right[..., None])[..., 0])


def estimated(equations: Equations, belief: Belief, certainty: float) -> tuple[Array, Array]:
    """The step (M, 4) to the maximum, and the covariance of the places, (M, 3, 3) m^2.

    It is s^2 (J^T W J)^-1 with s^2 from the errors themselves (H&Z, eq. 5.8). The prior of s^2 is 1 and
    counts as much as `certainty` errors, because a few errors determine s^2 poorly.
    """
    inverse = np.linalg.inv(equations.normal + belief.information)
    step = (inverse @ (equations.right + belief.vector)[..., None])[..., 0]
    redundant = np.maximum(2 * equations.trust.sum(axis=1) - 3, 0.0)
    scale = (certainty + equations.cost) / (certainty + redundant)
    return step, inverse[:, :3, :3] * scale[:, None, None]
