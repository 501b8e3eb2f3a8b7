"""Depths of edges: how many messages wait for a reader, if the graph file gives no depth."""

from __future__ import annotations

import math
from collections.abc import Mapping

MAX_DEPTH = 10_000
"""Largest depth of an edge."""
INPUT_DEPTHS: Mapping[str, int] = {"window": 1024, "nearest": 256}
"""Default depths of edges to sampled inputs, by kind: a second of a fast sensor, and the time that a stage
may lag behind one in a live run."""
LIVE_DEPTH = 2
"""Default number of messages of a live source that wait for the graph: one to take, and the next."""
_FAST = 100.0
"""Rate, Hz, above which every message of a live source is needed, and not the newest alone."""
_LONGEST_WORK = 0.5
"""Time, s, for which a worker may be busy before it loses messages of a fast source."""
MAX_IN_TRANSIT = 2
"""Messages in transit on an edge that drops; later ones wait in the sender, which can drop them."""


def live_depth(rate: float | None) -> int:
    """Default depth of a live source with this rate, Hz; sources faster than cameras keep half a second."""
    if rate is None or rate <= _FAST:
        return LIVE_DEPTH
    return min(math.ceil(rate * _LONGEST_WORK), MAX_DEPTH)
