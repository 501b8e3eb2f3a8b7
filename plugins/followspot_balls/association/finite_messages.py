"""Messages without the rows of unknown numbers: a NaN would spoil all that it is added to."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from followspot import Array
from followspot.tracking import LOST, Candidates, Forecast


def finite_candidates(candidates: Candidates) -> Candidates:
    """The candidates whose position and blobs are known; the same message if all are."""
    numbers = candidates.xyz, candidates.area, candidates.xy
    if finite(*numbers):
        return candidates
    known = [np.isfinite(column).reshape(len(column), -1).all(axis=1) for column in numbers]
    return candidates.where(np.logical_and.reduce(known))


def finite_forecast(forecast: Forecast | None) -> Forecast | None:
    """The forecast, in which a target without a known position is lost; the same message if all are known."""
    if forecast is None:
        return None
    if finite(forecast.xyz, forecast.covariance):
        return forecast
    positions, spreads = np.isfinite(forecast.xyz), np.isfinite(forecast.covariance)
    known = np.asarray(positions.all(axis=1) & spreads.all(axis=(1, 2)))
    return replace(
        forecast,
        state=np.where(known, forecast.state, LOST).astype(np.uint8),
        xyz=np.where(known[:, None], forecast.xyz, 0.0),
        covariance=np.where(known[:, None, None], forecast.covariance, 0.0),
    )


def finite(*columns: Array) -> bool:
    """Whether all numbers of some columns are finite; False also if their squares are too large to add up.

    The sum of the squares costs a third of looking at each number.
    """
    return math.isfinite(sum(np.vdot(column, column) for column in columns))
