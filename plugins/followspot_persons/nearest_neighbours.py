"""Global nearest neighbours: pairs of least cost together (Blackman & Popoli 1999, section 6.4)."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.assignment import assigned


def matched(cost: Array, limit: float) -> list[tuple[int, int]]:
    """Pairs (row, column) of least cost together, each row and column at most once, none above the limit.

    To stay apart costs the limit.
    cost: (K, N), lower is better. Returns the pairs, the surest first.
    """
    gain = np.nextafter(limit, np.inf) - np.where(np.isfinite(cost), cost, np.inf).astype(float)
    rows, columns = assigned(gain)
    order = np.argsort(-gain[rows, columns], kind="stable")
    return list(zip(rows[order].tolist(), columns[order].tolist(), strict=True))
