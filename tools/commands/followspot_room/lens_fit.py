"""Lenses of other models as a pinhole or a fisheye that shows the same directions at the same pixels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np

from followspot.geometry import project_local
from followspot.messages import Array
from followspot.room import Camera, LensModel
from followspot_room.checks import Unfit

GRID = (25, 19)
"""Columns and rows of the pixels in which lenses are compared."""
LARGEST_ERROR = 0.5
"""Largest distance of a pixel that is passed over, px; a detected corner or blob is no better."""
ROUNDS = 60
"""Steps of Levenberg and Marquardt; they end when nothing changes, usually after ten."""
STEP = 1e-6
"""Of numerical derivatives, over the size of a parameter."""
EXACT = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-10)
CLOSE = 0.01
"""px; a pixel whose direction does not lead back to it lies where the model folds."""
COEFFICIENTS: dict[LensModel, int] = {"pinhole": 5, "fisheye": 4}


def grid_of(size: tuple[int, int]) -> Array:
    """Pixels spread over a picture and its edges: (N, 2) px."""
    across, down = (np.linspace(0, side - 1, count) for side, count in zip(size, GRID, strict=True))
    return np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)


def simplified(camera: Camera, directions: Callable[[Array], Array], lens: str) -> tuple[Camera, str]:
    """The camera with a lens of its own model or as a fisheye, whichever fits, and a note that says how well.

    directions: of pixels, (N, 2) px -> (N, 3) in camera coordinates, NaN where the other model has none;
    lens: names that model. Raises Unfit beyond `LARGEST_ERROR`.
    """
    pixel = grid_of(camera.size)
    rays = directions(pixel)
    known = np.isfinite(rays).all(axis=1) & (rays[:, 2] > 0)
    if known.mean() < 0.5:
        raise Unfit(
            f"camera {camera.name}: its {lens} has no directions for most pixels", "check its numbers"
        )
    models: tuple[LensModel, ...] = ("pinhole", "fisheye")
    found = [fitted(camera, model, rays[known], pixel[known]) for model in models]
    best, error = min(found, key=lambda one: one[1])
    if not error <= LARGEST_ERROR:
        text = f"camera {camera.name}: its {lens} fits no pinhole and no fisheye, it is {error:.1f} px off"
        raise Unfit(text, "calibrate it anew: followspot calibrate intrinsics")
    return best, f"camera {camera.name}: its {lens} became a {best.model}, at most {error:.2g} px off"


def fitted(camera: Camera, model: LensModel, rays: Array, pixel: Array) -> tuple[Camera, float]:
    """The camera with the matrix and distortion of a model that fit best, and its largest error, px.

    rays: (N, 3) in camera coordinates; pixel: (N, 2) px. Infinite where the model has no image of a ray.
    """
    K = camera.matrix
    start = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *np.zeros(COEFFICIENTS[model])])
    scale = np.array([K[0, 0], K[1, 1], K[0, 0], K[1, 1], *np.ones(COEFFICIENTS[model])])

    def camera_of(values: Array) -> Camera:
        fx, fy, cx, cy = values[:4]
        matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        return replace(camera, model=model, matrix=matrix, distortion=values[4:].copy())

    def error_of(values: Array) -> Array:
        return np.asarray((project_local(camera_of(values), rays) - pixel).ravel())

    best = camera_of(least_squares(error_of, start, scale))
    apart = np.linalg.norm(project_local(best, rays) - pixel, axis=1)
    return best, float(apart.max()) if np.isfinite(apart).all() else np.inf


def least_squares(error_of: Callable[[Array], Array], start: Array, scale: Array) -> Array:
    """Parameters, (P,), with the least sum of squared errors (H&Z, appendix A6.2).

    scale: (P,), a size of each parameter.
    """
    values, error, damping = start, error_of(start), 1e-3
    for _ in range(ROUNDS):
        steps = np.diag(STEP * scale)
        slope = np.stack([(error_of(values + step) - error) / STEP for step in steps], axis=1)
        normal, aim = slope.T @ slope, slope.T @ error
        damped = normal + damping * np.diag(np.maximum(np.diagonal(normal), 1e-9))
        tried = values - np.linalg.lstsq(damped, aim, rcond=None)[0] * scale
        left = error_of(tried)
        if not left @ left < error @ error:  # also for NaN
            damping *= 10
            if damping > 1e9:
                break
            continue
        done = error @ error - left @ left < 1e-12 * (error @ error)
        values, error, damping = tried, left, damping / 10
        if done:
            break
    return values


def undistorted(matrix: Array, lens: Array, pixel: Array) -> Array:
    """Images without distortion by OpenCV's coefficients, with a matrix of 1: (N, 2) px -> (N, 3), z = 1.

    NaN for pixels beyond the radius up to which the model is one to one.
    """
    xy = cv2.undistortPointsIter(pixel[:, None], matrix, lens, np.eye(3), np.eye(3), EXACT)[:, 0]
    rays = np.column_stack([xy, np.ones(len(xy))])
    back = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, lens)[0].reshape(-1, 2)
    good = np.linalg.norm(back - pixel, axis=1) < CLOSE
    return np.asarray(np.where(good[:, None], rays, np.nan))
