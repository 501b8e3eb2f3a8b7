"""How far apart cameras take the pictures of one moment, from their capture times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from followspot.messages import Array

FEWEST = 5
"""Pictures that each camera must give while all give pictures."""
NORMAL = 1.4826
"""Standard deviation of a normal distribution over its median deviation."""


@dataclass(frozen=True)
class Timing:
    """One camera. rate: pictures a second, on the whole; late: median of how much later than the others it
    takes its pictures, ms; jitter: of that, one sigma, ms.
    """

    rate: float
    late: float
    jitter: float


@dataclass(frozen=True)
class Spread:
    """All cameras. usual, most: between the first and the last picture of a moment, median and 95 %, ms."""

    cameras: Mapping[str, Timing]
    usual: float
    most: float


def spread_of(times: Mapping[str, Array]) -> Spread | None:
    """The spread of capture times over at least two cameras; None if too few pictures are of one time.

    times: camera -> (N,) int64 ns, ascending. A moment is a picture of the slowest camera, with the nearest
    picture of each other one. Lateness is relative to the median of the cameras, of two to the first.
    """
    begin = max(int(t[0]) if len(t) else 0 for t in times.values())
    end = min(int(t[-1]) if len(t) else 0 for t in times.values())
    # Seconds since 1970 leave a float no nanoseconds, so times count from the beginning.
    since = {name: (t - begin) / 1e6 for name, t in times.items()}
    within = {name: t[(t >= 0) & (t <= (end - begin) / 1e6)] for name, t in since.items()}
    if len(within) < 2 or min(map(len, within.values())) < FEWEST:
        return None
    slowest = min(within.values(), key=len)
    moments = np.column_stack([_nearest(t, slowest) for t in since.values()])  # also just before the begin
    middle = np.median(moments, axis=1) if len(times) > 2 else moments[:, 0]
    late = moments - middle[:, None]
    usual = np.median(late, axis=0)
    jitter = NORMAL * np.median(np.abs(late - usual), axis=0)
    apart = np.ptp(moments, axis=1)
    cameras = {
        name: Timing(1000 * (len(t) - 1) / float(t[-1] - t[0]), float(usual[k]), float(jitter[k]))
        for k, (name, t) in enumerate(within.items())
    }
    return Spread(cameras, float(np.median(apart)), float(np.percentile(apart, 95)))


def _nearest(times: Array, moments: Array) -> Array:
    """The time nearest to each moment: (N,) ascending, (M,) -> (M,)."""
    after = np.clip(np.searchsorted(times, moments), 1, len(times) - 1)
    before = after - 1
    nearer = moments - times[before] < times[after] - moments
    return np.asarray(np.where(nearer, times[before], times[after]))
