"""The motion of a thrown ball in a picture: the image of a parabola (Hartley & Zisserman, section 6.1).

A free ball is at X(t) = X0 + V t + G t^2 / 2. A pinhole camera makes of it three quadratics in time up to
scale, x ~ P X(t): the quotient of two quadratics for u, and of two with the same divisor for v. A plain
parabola is the case of a flight parallel to the image plane.
"""

from __future__ import annotations

import numpy as np

from followspot import Array

STEPS = 3
"""Iterations of the linear problem, each weighted by the depths of the previous one."""


def residual(time: Array, xy: Array) -> float:
    """RMS distance of a path from the best image of a parabola, px; infinite if that passes the camera.

    time: (N,) s; xy: (N, 2) px without distortion; N at least 5. The quotients are fitted as linear
    equations divided by the last depths (the weights of Hartley & Zisserman, section 4.7), in normalised
    coordinates.
    """
    span = centred(time)
    powers = np.column_stack([np.ones_like(span), span, span**2])
    scale = float(np.abs(xy - xy.mean(axis=0)).max()) or 1.0
    image = (xy - xy.mean(axis=0)) / scale
    none = np.zeros_like(powers)
    divisor = -image.T[:, :, None] * powers[:, 1:]
    equations = np.vstack([np.hstack([powers, none, divisor[0]]), np.hstack([none, powers, divisor[1]])])
    depth = np.ones_like(span)
    for _ in range(STEPS):
        weight = 1 / np.concatenate([depth, depth])
        solved = np.linalg.lstsq(equations * weight[:, None], image.T.reshape(-1) * weight, rcond=None)[0]
        depth = 1 + powers[:, 1:] @ solved[6:]
        if depth.min() <= 0:
            return np.inf
    fitted = powers @ solved[:6].reshape(2, 3).T / depth[:, None]
    return scale * float(np.sqrt(np.square(fitted - image).sum(axis=1).mean()))


def bend(time: Array, v: Array) -> float:
    """How far the path rises above the straight line between its ends, px: the sagitta of its parabola.

    time: (N,) s; v: (N,) px, downwards; N at least 3. Negative if the path is convex.
    """
    return float(np.polyfit(centred(time), v, 2)[0])


def centred(time: Array) -> Array:
    """Times moved and scaled to [-1, 1]."""
    half = (time[-1] - time[0]) / 2
    return np.asarray((time - time[0]) / half - 1)
