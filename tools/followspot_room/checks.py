"""Checks of numbers that another program wrote."""

from __future__ import annotations

from typing import Any

import numpy as np

from followspot.messages import Array

ROTATION_TOLERANCE = 1e-3
"""Largest deviation of R R^T from the identity; files round to a few decimals."""


class Unfit(ValueError):
    """A value does not fit; the text says where, what it is and what it should be."""


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


def plane(value: Any, where: str) -> Array:
    """[a b c d] with a unit normal, (4,) m. Raises Unfit."""
    numbers = array(value, (4,), where)
    length = np.linalg.norm(numbers[:3])
    if length < 1e-9:
        raise Unfit(f"{where} has no normal")
    return np.asarray(numbers / length)
