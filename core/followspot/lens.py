"""Lens models: from camera coordinates to pixels and back, for each model of `followspot.room.Camera`.

The models are pinhole (OpenCV's polynomials), rational (quotients of these), fisheye (as in OpenCV) and
cylinder (a panorama). Local points are in camera coordinates: x right, y down, z forward. `pixel` and `xy`
as in `followspot.geometry`, which has the functions for points of the room.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import Polynomial

from followspot.messages import Array
from followspot.room import Camera

MAX_ITERATIONS = 100
"""Most iterations of the inversion of a lens model; it needs 5 to 20."""
TOLERANCE = 1e-12
"""Step at which the inversion of a lens model stops, in focal lengths (fisheye) or px (pinhole)."""
POLYNOMIAL = ("pinhole", "rational")
"""Models with distortions that are polynomials of OpenCV, or quotients of them."""
_NEGLIGIBLE = 1e-100
"""Highest coefficients up to this are taken for 0: they only matter beyond any angle of a lens."""
IDENTITY = np.eye(3)
ORIGIN = np.zeros(3)


def _project_polynomial(camera: Camera, local: Array) -> Array:
    """Images of a pinhole camera or rational lens; NaN behind the camera (z <= 0)."""
    import cv2

    if len(local) == 0:
        return np.empty((0, 2))
    pixel = cv2.projectPoints(local, IDENTITY, ORIGIN, camera.matrix, camera.distortion)[0][:, 0]
    pixel[local[:, 2] <= 0] = np.nan
    return _sheared(camera, pixel, 1.0)


def _project_fisheye(camera: Camera, local: Array) -> Array:
    across = np.hypot(local[:, 0], local[:, 1])
    angle = _fisheye_angle(camera.distortion, np.arctan2(across, local[:, 2]))
    scale = np.divide(angle, across, out=np.zeros_like(across), where=across > 0)
    return _denormalise(camera, scale * local[:, 0], scale * local[:, 1])


def _project_cylinder(camera: Camera, local: Array) -> Array:
    around = np.arctan2(local[:, 0], local[:, 2])
    return _denormalise(camera, around, local[:, 1] / np.hypot(local[:, 0], local[:, 2]))


PROJECT: dict[str, Callable[[Camera, Array], Array]] = {
    "pinhole": _project_polynomial,
    "rational": _project_polynomial,
    "fisheye": _project_fisheye,
    "cylinder": _project_cylinder,
}
"""By model: images of points in camera coordinates, (N, 3) m -> (N, 2) px with distortion."""


def fold(camera: Camera) -> float:
    """Tangent of the angle off the axis at which a lens begins to image farther points nearer to its middle.

    There a polynomial that was fitted to the picture turns round; images of points beyond mean nothing.
    Infinite for a lens that does not, and for models without polynomials of the tangent.
    """
    if camera.model not in POLYNOMIAL:
        return np.inf
    k1, k2, _, _, k3, k4, k5, k6 = np.pad(camera.distortion, (0, 8 - len(camera.distortion)))
    over, under = Polynomial([1.0, k1, k2, k3]), Polynomial([1.0, k4, k5, k6])
    s = Polynomial([0.0, 1.0])  # squared tangent; the image is at r over(s) / under(s)
    growth = (over + 2 * s * over.deriv()) * under - 2 * s * over * under.deriv()
    turns = np.concatenate([growth.trim(_NEGLIGIBLE).roots(), under.trim(_NEGLIGIBLE).roots()])
    return float(np.sqrt(turns.real[(turns.imag == 0) & (turns.real > 0)].min(initial=np.inf)))


def local_rays(camera: Camera, pixel: Array) -> Array:
    """Viewing directions in camera coordinates, of any length: (N, 2) px with distortion -> (N, 3)."""
    if camera.model not in POLYNOMIAL:
        x, y = normalise(camera, pixel).T
        if camera.model == "cylinder":
            return np.column_stack([np.sin(x), y, np.cos(x)])
        return _fisheye_rays(camera.distortion, x, y)
    normalised = normalise(camera, undistort_polynomial(camera, pixel))
    return np.column_stack([normalised, np.ones(len(pixel))])


def undistort_polynomial(camera: Camera, pixel: Array) -> Array:
    """Remove the lens distortion of a pinhole camera or rational lens: (N, 2) px -> (N, 2) px."""
    import cv2

    if len(pixel) == 0:
        return np.empty((0, 2))
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, MAX_ITERATIONS, TOLERANCE)
    K = camera.matrix
    pixel = _sheared(camera, pixel, -1.0)
    return np.asarray(cv2.undistortPointsIter(pixel[:, None], K, camera.distortion, IDENTITY, K, stop)[:, 0])


def _sheared(camera: Camera, pixel: Array, sign: float) -> Array:
    """Add (sign 1) or remove (sign -1) the skew of the matrix, which OpenCV's functions pass over.

    pixel: (N, 2) px. Returns (N, 2) px; the same array without a skew.
    """
    K = camera.matrix
    if K[0, 1] == 0:
        return pixel
    x, y = pixel.T
    return np.column_stack([x + sign * K[0, 1] * (y - K[1, 2]) / K[1, 1], y])


def pinhole_image(camera: Camera, local: Array) -> Array:
    """Images of points in camera coordinates without distortion: (N, 3) m -> (N, 2) px; NaN where z <= 0."""
    z = np.where(local[:, 2] > 0, local[:, 2], np.nan)
    return _denormalise(camera, local[:, 0] / z, local[:, 1] / z)


def normalise(camera: Camera, xy: Array) -> Array:
    """K^-1 (x, y, 1) without its last entry: (N, 2) px -> (N, 2)."""
    K = camera.matrix
    y = (xy[:, 1] - K[1, 2]) / K[1, 1]
    return np.column_stack([(xy[:, 0] - K[0, 2] - K[0, 1] * y) / K[0, 0], y])


def _denormalise(camera: Camera, x: Array, y: Array) -> Array:
    """The inverse of `normalise`: x, y (N,) -> (N, 2) px."""
    K = camera.matrix
    return np.column_stack([K[0, 0] * x + K[0, 1] * y + K[0, 2], K[1, 1] * y + K[1, 2]])


def _fisheye_angle(distortion: Array, theta: Array) -> Array:
    """Distorted angle theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)."""
    k1, k2, k3, k4 = distortion
    t2 = theta * theta
    return np.asarray(theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)))))


def _fisheye_rays(distortion: Array, x: Array, y: Array) -> Array:
    """Unit vectors, (N, 3), of normalised points x, y (N,); inverts `_fisheye_angle` by Newton's method."""
    k1, k2, k3, k4 = distortion
    distorted = np.hypot(x, y)
    theta = np.minimum(distorted, np.pi / 2)
    for _ in range(MAX_ITERATIONS):
        t2 = theta * theta
        slope = 1 + t2 * (3 * k1 + t2 * (5 * k2 + t2 * (7 * k3 + t2 * 9 * k4)))
        step = (_fisheye_angle(distortion, theta) - distorted) / slope
        theta = theta - step
        if not (np.abs(step) > TOLERANCE).any():
            break
    scale = np.divide(np.sin(theta), distorted, out=np.ones_like(theta), where=distorted > 0)
    return np.column_stack([scale * x, scale * y, np.cos(theta)])
