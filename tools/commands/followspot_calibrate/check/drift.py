"""The bias of each camera over time: whether it moved, and when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_calibrate.report import Course

WINDOWS = 24
"""Parts of a recording, each with one bias; fewer if they would hold fewer sightings than `FEWEST`."""
FEWEST = 15
CORRELATED = 4.0
"""Sightings that say as much as one: a ball that is half hidden is so for several frames."""
BETTER = 0.7
"""Distance of the windows from a step or slope over that from no change, above which it explains nothing."""
SURE = 4.0
"""Sigmas of a step or slope that is believed."""


@dataclass(frozen=True, eq=False)
class Change:
    """Change of a camera's bias.

    at: s, of a step, None for a slope; by: (2,) px, size of the step or of the slope over the whole time;
    sigma: px.
    """

    at: float | None
    by: Array
    sigma: float

    @property
    def size(self) -> float:
        """Length of the change, px."""
        return float(np.linalg.norm(self.by))


def course(camera: str, time: Array, residual: Array) -> Course:
    """Median residuals of successive parts of the time: time (N,) s, ascending; residual (N, 2) px."""
    known = np.isfinite(residual[:, 0])
    time, residual = time[known], residual[known]
    count = min(WINDOWS, len(time) // FEWEST)
    parts = np.array_split(np.arange(len(time)), count) if count else []
    middle = np.array([np.median(residual[part], axis=0) for part in parts]).reshape(-1, 2)
    sigma = np.array([_sigma(residual[part]) for part in parts])
    return Course(camera, np.array([time[part].mean() for part in parts]), middle, sigma)


def change(path: Course, time: Array, residual: Array) -> Change | None:
    """The step or slope that explains a course better than no change; None if none is sure.

    time, residual: as for `course`, to find the moment of a step.
    """
    if len(path.time) < 4:
        return None
    sigma = float(np.median(path.sigma))
    step, split = _step(path.bias)
    slope, line_cost = _slope(path.time, path.bias)
    if min(step, line_cost) > BETTER * _off(path.bias):
        return None
    if line_cost < step:
        found = Change(None, slope * (path.time[-1] - path.time[0]), sigma)
    else:
        before, after = (np.median(part, axis=0) for part in (path.bias[:split], path.bias[split:]))
        found = Change(_moment(time, residual, before, after), after - before, sigma)
    return found if found.size > SURE * sigma else None


def _sigma(residual: Array) -> float:
    """Standard deviation of the median of correlated sightings, px."""
    spread = 1.4826 * np.median(np.abs(residual - np.median(residual, axis=0)), axis=0)
    return float(1.2533 * np.linalg.norm(spread) / np.sqrt(len(residual) / CORRELATED))


def _step(bias: Array) -> tuple[float, int]:
    """Least distance from two levels, and the first window of the second: (W, 2)."""
    costs = [_off(bias[:k]) + _off(bias[k:]) for k in range(1, len(bias))]
    best = int(np.argmin(costs))
    return costs[best], best + 1


def _slope(time: Array, bias: Array) -> tuple[Array, float]:
    """Slope (2,) px/s of the line through the windows (Theil-Sen), and the distance from it."""
    i, j = np.triu_indices(len(time), 1)
    slope = np.median((bias[j] - bias[i]) / (time[j] - time[i])[:, None], axis=0)
    return slope, _off(bias - time[:, None] * slope)


def _off(bias: Array) -> float:
    """Sum of the distances from the median: single windows full of half-hidden targets weigh little."""
    return float(np.linalg.norm(bias - np.median(bias, axis=0), axis=1).sum())


def _moment(time: Array, residual: Array, before: Array, after: Array) -> float:
    """The time at which sightings go over from one level to the other, s."""
    known = np.isfinite(residual[:, 0])
    time, residual = time[known], residual[known]
    nearer = np.linalg.norm(residual - before, axis=1) - np.linalg.norm(residual - after, axis=1)
    size = np.linalg.norm(after - before)
    gain = np.concatenate([[0.0], np.cumsum(np.clip(nearer, -size, size))])
    return float(time[min(int(gain.argmin()), len(time) - 1)])
