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
"""Depth that stands for any behind the camera, m."""


class Images(NamedTuple):
    """Where points appear."""

    xy: Array
    """(M, C, 2) px, undistorted."""
    depth: Array
    """(M, C) m; BEHIND for points that have no image."""


class Model(NamedTuple):
    """How M points appear in C views: x ~ matrix p + offset for parameters p."""

    matrix: Array
    """(M, C, 3, 4)."""
    offset: Array
    """(C, 3)."""


class Belief(NamedTuple):
    """What is known of parameters beside the views: a Gaussian."""

    mean: Array
    """(M, 4)."""
    information: Array
    """(M, 4, 4), the inverse of the covariance; 0 where nothing is known."""


class Views(NamedTuple):
    """One blob for each point and view."""

    xy: Array
    """(M, C, 2) px; any number where there is none."""
    precision: Array
    """(M, C) 1/px^2, inverse variance along each axis; 0 where there is none."""
    cutoff2: Array
    """(M, C) px^2, square of the error at which a view keeps a quarter of its weight."""


class Equations(NamedTuple):
    """Weighted normal equations of a step d from the parameters they were set up at: normal d = right."""

    normal: Array
    """(M, 4, 4)."""
    right: Array
    """(M, 4)."""
    trust: Array
    """(M, C) robust weight of each view, 1 for one that fits, 0 where there is none."""
    cost: Array
    """(M,) sum of weighted squared errors."""


def glowing_model(P: Array, normal: Array, color: Array) -> Model:
    """The model of points whose colour images lie off by their glow along a normal.

    P: (C, 3, 4); normal: (M, 3); color: (C,) bool.
    """
    matrix = np.empty((len(normal), len(P), 3, PARAMETERS))
    matrix[..., :3] = P[:, :, :3]
    matrix[..., 3] = (P[:, :, :3] @ normal[:, None, :, None])[..., 0] * color[:, None]
    return Model(matrix, P[:, :, 3])


def images(model: Model, parameters: Array) -> Images:
    """(M, 4) -> images in all views."""
    x = (model.matrix @ parameters[:, None, :, None])[..., 0] + model.offset
    return _flattened(x)


def point_images(P: Array, xyz: Array) -> Images:
    """Images of points without glow: (C, 3, 4), (M, 3) m."""
    return _flattened((xyz @ P[:, :, :3].reshape(-1, 3).T).reshape(len(xyz), -1, 3) + P[:, :, 3])


def _flattened(x: Array) -> Images:
    depth = np.maximum(x[..., 2], BEHIND)
    return Images(x[..., :2] / depth[..., None], depth)


def linearised(model: Model, seen: Images, views: Views) -> tuple[Array, Array]:
    """Jacobian of the images (M, 2C, 4) px per unit, and errors of the views (M, 2C) px."""
    A = model.matrix
    J = (A[:, :, :2] - seen.xy[..., None] * A[:, :, 2:]) / seen.depth[..., None, None]
    count = len(A)
    return J.reshape(count, -1, PARAMETERS), (views.xy - seen.xy).reshape(count, -1)


def weighted(J: Array, errors: Array, step: Array, views: Views) -> Equations:
    """Normal equations with the weights of Geman and McClure, (1 + e^2 / c^2)^-2, after a step.

    J, errors: see :func:`linearised`; step: (M, 4).
    """
    count, cameras = views.precision.shape
    left = (errors - (J @ step[..., None])[..., 0]).reshape(count, cameras, 2)
    squares = np.einsum("mci,mci->mc", left, left)
    trust = np.square(views.cutoff2 / (views.cutoff2 + squares)) * (views.precision > 0)
    weight = trust * views.precision
    JW = (J * np.repeat(weight, 2, axis=1)[..., None]).swapaxes(1, 2)
    return Equations(JW @ J, (JW @ errors[..., None])[..., 0], trust, (weight * squares).sum(axis=1))


def solved(equations: Equations, parameters: Array, *beliefs: Belief) -> Array:
    """The step (M, 4) from the parameters to the maximum of views and beliefs together."""
    normal, right = equations.normal, equations.right
    for mean, information in beliefs:
        normal = normal + information
        right = right + (information @ (mean - parameters)[..., None])[..., 0]
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])


def covariance(equations: Equations, belief: Belief, certainty: float) -> Array:
    """Covariance of the places, (M, 3, 3) m^2: s^2 (J^T W J)^-1 with s^2 from the errors themselves.

    A few errors tell little of s^2, so 1 is taken for it as if `certainty` more of them had said so.
    """
    inverse = np.linalg.inv(equations.normal + belief.information)[:, :3, :3]
    redundant = np.maximum(2 * equations.trust.sum(axis=1) - 3, 0.0)
    scale = (certainty + equations.cost) / (certainty + redundant)
    return np.asarray(inverse * scale[:, None, None])
