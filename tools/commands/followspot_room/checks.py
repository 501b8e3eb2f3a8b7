"""Checks of numbers that another program wrote."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

import cv2
import numpy as np

from followspot.messages import Array
from followspot.room import Camera, LensModel

ROTATION_TOLERANCE = 1e-3
"""Largest deviation of R R^T from the identity; files round to a few decimals."""
MOST_CAMERAS = 1000
LARGEST_SIDE = 1 << 15
"""px"""
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]{0,63}")
RATIONAL = 8
COEFFICIENTS: dict[LensModel, tuple[int, ...]] = {"pinhole": (0, 4, 5), "fisheye": (4,)}


HELD_BY: dict[LensModel, str] = {
    "fisheye": "export it as anipose or opencv",
    "rational": "export it as opencv",
}
"""Remedies for models that a format lacks."""


class Unfit(ValueError):
    """A value does not fit; the text says where it is, its value and the expected one; remedy: what to do."""

    def __init__(self, text: str, remedy: str = "") -> None:
        super().__init__(text)
        self.remedy = remedy


def array(value: Any, shape: tuple[int, ...], where: str) -> Array:
    """Finite numbers of this shape, float64. Raises Unfit."""
    try:
        numbers = np.array(value, "f8")
    except (TypeError, ValueError):
        raise Unfit(f"{where} is not made of numbers") from None
    if numbers.shape != shape:
        raise Unfit(f"{where} has shape {numbers.shape}, needs {shape}")
    if not np.isfinite(numbers).all():
        raise Unfit(f"{where} has a number that is not finite")
    return numbers


def rotation(value: Any, where: str) -> Array:
    """A rotation matrix, (3, 3). Raises Unfit."""
    matrix = array(value, (3, 3), where)
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(matrix) < 0:
        raise Unfit(f"{where} is no rotation: R R^T = I and det R = 1 do not hold")
    return matrix


def rotation_or_vector(value: Any, where: str) -> Array:
    """A rotation matrix, (3, 3), from itself or from a Rodrigues vector of 3 numbers, rad. Raises Unfit."""
    if np.size(np.array(value, object)) == 3:
        vector = array(np.ravel(np.array(value, object)).tolist(), (3,), where)
        return np.asarray(cv2.Rodrigues(vector)[0])
    return rotation(value, where)


def plane(value: Any, where: str) -> Array:
    """[a b c d] with a unit normal, (4,) m. Raises Unfit."""
    numbers = array(value, (4,), where)
    length = np.linalg.norm(numbers[:3])
    if length < 1e-9:
        raise Unfit(f"{where} has no normal")
    return np.asarray(numbers / length)


def name(value: Any, where: str) -> str:
    """A name that a room file accepts. Raises Unfit."""
    if not isinstance(value, str) or not NAME.fullmatch(value):
        raise Unfit(f"{where} has the name {value!r}; needs letters, digits, _ -", "rename it in the file")
    return value


def side(value: Any, where: str) -> int:
    """Width or height of a picture, px; 1088.0 is accepted. Raises Unfit."""
    whole = isinstance(value, int | float) and not isinstance(value, bool) and value % 1 == 0
    if not whole or not 0 < value <= LARGEST_SIDE:
        raise Unfit(f"{where} is {value!r}, needs a number of pixels", f"write 1 to {LARGEST_SIDE}")
    return int(value)


def camera_matrix(value: Any, where: str) -> Array:
    """K, (3, 3) px. Raises Unfit."""
    K = array(value, (3, 3), where)
    if K[0, 0] <= 0 or K[1, 1] <= 0 or K[1, 0] or list(K[2]) != [0, 0, 1]:
        raise Unfit(f"{where} is no camera matrix [[fx, s, cx], [0, fy, cy], [0, 0, 1]]")
    return K


def distortion(value: Any, model: LensModel, where: str) -> Array:
    """Distortion of a pinhole k1 k2 p1 p2 k3, (5,), filled up with zeros; of a fisheye (4,).

    Raises Unfit.
    """
    wanted = COEFFICIENTS[model]
    numbers = np.ravel(np.array(value, object)).tolist()
    if not isinstance(value, list) or len(numbers) not in wanted:
        listed = "k1, k2, k3 and k4" if model == "fisheye" else "k1, k2, p1, p2 and k3, or eight coefficients"
        raise Unfit(f"{where} needs {listed}", "calibrate without the thin-prism or tilted model")
    checked = array(numbers, (len(numbers),), where)
    return np.concatenate([checked, np.zeros(wanted[-1] - len(checked))])


def lens(value: Any, model: LensModel, where: str) -> tuple[LensModel, Array]:
    """Model and distortion: eight coefficients of a pinhole are OpenCV's rational model. Raises Unfit.

    Without k4, k5 and k6 that is the pinhole itself.
    """
    numbers = np.ravel(np.array(value, object)).tolist()
    if model != "pinhole" or not isinstance(value, list) or len(numbers) != RATIONAL:
        return model, distortion(value, model, where)
    checked = array(numbers, (RATIONAL,), where)
    return ("rational", checked) if checked[5:].any() else ("pinhole", checked[:5])


def unique(cameras: Sequence[Camera]) -> tuple[Camera, ...]:
    """The cameras, if their names differ. Raises Unfit."""
    if len(cameras) > MOST_CAMERAS:
        raise Unfit(f"{len(cameras)} cameras, at most {MOST_CAMERAS}")
    names = [camera.name for camera in cameras]
    twice = sorted({one for one in names if names.count(one) > 1})
    if twice:
        raise Unfit(f"camera {twice[0]} is there twice", "give each camera a name of its own")
    return tuple(cameras)


def holds(cameras: Iterable[Camera], models: Sequence[LensModel], format_name: str) -> None:
    """Raise Unfit for the first camera with a model that the format lacks."""
    for camera in cameras:
        if camera.model not in models:
            remedy = HELD_BY.get(camera.model, "leave it out of the room")
            raise Unfit(f"camera {camera.name} is a {camera.model}, which {format_name} cannot hold", remedy)
