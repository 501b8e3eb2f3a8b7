"""Bodies as ellipsoids, whose outline's box is known in closed form, and boxes as measurements.

The image of the dual quadric Q* is the dual conic C* = P Q* P^T (Hartley & Zisserman, eq. 8.5). One axis of
an ellipsoid is vertical. The matrix of the other two is w exp([[a, b], [b, -a]]): w is their geometric mean,
and with a = e cos 2t and b = e sin 2t the half axis in the direction t is w exp(e), the one across it
w exp(-e). A round body has a = b = 0.

The state of a body is x, y, z (m) of its middle, its velocity (m/s), the logarithms of w and of half its
height (m), a and b.
"""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.associate.multi_view.views import NEAREST, View

PLACE, SPEED, WIDTH, HEIGHT, ELONGATION = slice(0, 3), slice(3, 6), 6, 7, slice(8, 10)
"""Columns of a state."""
SHAPE, SIZE = slice(6, 10), 10
"""Columns of the shape, and number of columns."""
_MEASURED = (0, 1, 2, 6, 7, 8, 9)
_STEP = 1e-4


def boxes_of(view: View, state: Array) -> tuple[Array, Array]:
    """Boxes x0, y0, x1, y1 (..., 4) px about bodies (..., 10), and depths (...) m; NaN if a camera cannot see
    the whole body in front of it.
    """
    P = view.projection
    d = state[..., PLACE] @ P[:, :3].T + P[:, 3]
    C = P[:, :3] @ squared_axes(state) @ P[:, :3].T - d[..., :, None] * d[..., None, :]
    scale = np.where((d[..., 2] > NEAREST) & (C[..., 2, 2] < 0), C[..., 2, 2], np.nan)
    middle = C[..., :2, 2] / scale[..., None]
    span = np.sqrt(middle**2 - np.diagonal(C, axis1=-2, axis2=-1)[..., :2] / scale[..., None])
    return np.concatenate([middle - span, middle + span], axis=-1), d[..., 2]


def slopes_of(view: View, state: Array) -> tuple[Array, Array, Array]:
    """Boxes (M, 4), depths (M,), and the change of boxes with states, (M, 4, 10), by differences."""
    box, depth = boxes_of(view, state)
    moved = np.repeat(state[None], len(_MEASURED), axis=0)
    for row, column in enumerate(_MEASURED):
        moved[row, :, column] += _STEP
    slope = np.zeros((*box.shape, SIZE))
    slope[..., list(_MEASURED)] = np.moveaxis((boxes_of(view, moved)[0] - box) / _STEP, 0, -1)
    return box, depth, slope


def squared_axes(state: Array) -> Array:
    """Square of the matrix of the half axes of bodies (..., 10): (..., 3, 3) m^2."""
    across, down = np.exp(2 * state[..., WIDTH]), np.exp(2 * state[..., HEIGHT])
    a, b = np.moveaxis(state[..., ELONGATION], -1, 0)
    e = np.maximum(np.hypot(a, b), 1e-9)
    both, apart = across * np.cosh(2 * e), across * np.sinh(2 * e) / e
    squares = np.zeros((*a.shape, 3, 3))
    squares[..., 0, 0], squares[..., 1, 1], squares[..., 2, 2] = both + apart * a, both - apart * a, down
    squares[..., 0, 1] = squares[..., 1, 0] = apart * b
    return squares
