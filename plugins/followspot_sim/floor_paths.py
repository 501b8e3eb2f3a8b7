"""Paths of balls on the floor during a round."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from followspot import Array
from followspot_sim.rounds import ROLL, ROUND, smoothstep

MOMENTS = 40
"""Times of a round at which a path is known."""


def rolling(start: Array, goal: Array) -> Array:
    """Positions of a rolling ball at all moments of a round, (MOMENTS, 2) m."""
    u = np.linspace(0, ROUND, MOMENTS)[:, None]
    return np.asarray(start + (goal - start) * smoothstep((u - ROLL[0]) / (ROLL[1] - ROLL[0])))


def still(xyz: Array | tuple[float, float, float]) -> Array:
    """Positions of a ball that lies, as :func:`rolling`."""
    return np.tile(np.asarray(xyz)[:2], (MOMENTS, 1))


def clear(path: Array, others: Iterable[Array], gap: float) -> bool:
    """Whether a ball on the floor stays this far (m, between centres) from the others at all moments."""
    return all(np.hypot(*(path - other).T).min() > gap for other in others)
