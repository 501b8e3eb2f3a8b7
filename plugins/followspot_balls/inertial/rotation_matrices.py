"""Rotation matrices from rotation vectors, vectorised over leading dimensions."""

from __future__ import annotations

import numpy as np

from followspot import Array

_IDENTITY = np.eye(3)
_TINY = 1e-150
"""rad; keeps the division by an angle of 0 finite."""
_CROSS = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ]
)
"""[v]_x as a linear map of v."""


def cross_matrices(v: Array) -> Array:
    """[v]_x with [v]_x w = v x w. v: (..., 3). Returns (..., 3, 3)."""
    return np.asarray((v @ _CROSS).reshape(*v.shape, 3))


def rotation_exp(vector: Array) -> Array:
    """Rotation matrices exp([v]_x), by |v| about v (Rodrigues): (..., 3) rad -> (..., 3, 3)."""
    half = 0.5 * np.sqrt(np.vecdot(vector, vector))[..., None, None] + _TINY
    cross = cross_matrices(vector)
    sine = np.sin(half)
    return np.asarray(
        _IDENTITY + (sine * np.cos(half) / half) * cross + (0.5 * np.square(sine / half)) * (cross @ cross)
    )


def quaternion_of(rotation: Array) -> Array:
    """The quaternion w, x, y, z with w >= 0 of a rotation matrix, (3, 3) -> (4,) (Shepperd 1978)."""
    diagonal = np.diagonal(rotation)
    squares = np.concatenate([[diagonal.sum()], 2 * diagonal - diagonal.sum()])
    largest = int(squares.argmax())
    k = np.empty((4, 4))
    k[0, 0] = 1 + squares[0]
    k[0, 1:] = k[1:, 0] = (
        rotation[2, 1] - rotation[1, 2],
        rotation[0, 2] - rotation[2, 0],
        rotation[1, 0] - rotation[0, 1],
    )
    k[1:, 1:] = rotation + rotation.T + (1 - diagonal.sum()) * _IDENTITY
    q = k[largest] / np.linalg.norm(k[largest])
    return np.asarray(-q if q[0] < 0 else q)
