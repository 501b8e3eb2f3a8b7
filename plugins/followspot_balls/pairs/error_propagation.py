"""Propagation of errors of rays to the points that are triangulated from pairs of them.

With unit rays a and b, their cosine c and sine s, a displacement d of the first ray moves the point along the
second one as far as d lies in their plane, and along their normal n = a x b by the first view's share f of
the information: (f n n^T + b (b - c a)^T) d / s^2. That is (I_a + I_b)^-1 I_a d for equal errors in angle,
with I_v = i_v (1 - v v^T). Across a, n n^T is s^2 P - P b b^T P with P = 1 - a a^T, so the pairs of a ray
enter by sums of b b^T alone.
"""

from __future__ import annotations

import numpy as np

from followspot.messages import Array

PARALLEL = 1e-6
"""Smallest squared sine of the angle between two rays."""


def propagation(weight: Array, rays: Array, variance: Array) -> Array:
    """Shift of M weighted means of points by a displacement of each ray there: (M, C, 3, 3), m per m.

    weight: (M, C, C), symmetric, of the points of two rays each; rays: (M, C, 3), unit vectors; variance:
    (M, C) m^2, of each ray across itself at the point, up to a factor.
    """
    modes, views, _ = rays.shape
    cosine = rays @ rays.swapaxes(1, 2)
    both = variance[:, None] + variance[:, :, None]
    share = weight / both
    alone = np.vecdot(share, variance[:, None])
    share /= np.maximum(1 - cosine * cosine, PARALLEL)
    coefficients = np.empty((2, modes, views, views))
    np.multiply(share, variance[:, None], out=coefficients[0])
    np.multiply(share, variance[:, :, None], out=coefficients[1])
    squares = (rays[..., None] * rays[:, :, None]).reshape(modes, views, 9)
    known, other = (coefficients @ squares).reshape(2, modes, views, 3, 3)
    shift = other + rays[..., None] * (rays[:, :, None] @ known)
    shift.reshape(modes, views, 9)[..., ::4] += alone[..., None]
    shift -= (shift @ rays[..., None]) * rays[:, :, None]
    return np.asarray(shift)
