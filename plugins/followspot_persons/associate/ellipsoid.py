"""Bodies as upright ellipsoids, whose outline's box is known in closed form, and boxes as measurements.

The state of a body is x, y, z (m) of its middle, its velocity, and the logarithms of half its width and half
its height. The image of the dual quadric Q* is the dual conic C* = P Q* P^T (Hartley & Zisserman, eq. 8.5).
"""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot_persons.associate.views import NEAREST, View

PLACE, SPEED, WIDTH, HEIGHT = slice(0, 3), slice(3, 6), 6, 7
_MEASURED = (0, 1, 2, WIDTH, HEIGHT)
_STEP = 1e-4


def boxes_of(view: View, state: Array) -> tuple[Array, Array]:
    """Boxes x0, y0, x1, y1 (..., 4) px about bodies (..., 8), and depths (...) m; NaN if a camera cannot see
    the whole body in front of it.
    """
    P = view.projection
    d = state[..., PLACE] @ P[:, :3].T + P[:, 3]
    half = np.exp(state[..., [WIDTH, WIDTH, HEIGHT]])
    C = np.einsum("ik,jk,...k->...ij", P[:, :3], P[:, :3], half**2) - d[..., :, None] * d[..., None, :]
    scale = np.where((d[..., 2] > NEAREST) & (C[..., 2, 2] < 0), C[..., 2, 2], np.nan)
    middle = C[..., :2, 2] / scale[..., None]
    span = np.sqrt(middle**2 - np.diagonal(C, axis1=-2, axis2=-1)[..., :2] / scale[..., None])
    return np.concatenate([middle - span, middle + span], axis=-1), d[..., 2]


def slopes_of(view: View, state: Array) -> tuple[Array, Array, Array]:
    """Boxes (M, 4), depths (M,), and the change of boxes with states, (M, 4, 8), by differences."""
    box, depth = boxes_of(view, state)
    moved = np.repeat(state[None], len(_MEASURED), axis=0)
    for row, column in enumerate(_MEASURED):
        moved[row, :, column] += _STEP
    slope = np.zeros((*box.shape, 8))
    slope[..., list(_MEASURED)] = np.moveaxis((boxes_of(view, moved)[0] - box) / _STEP, 0, -1)
    return box, depth, slope
