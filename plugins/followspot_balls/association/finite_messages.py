"""Messages without the rows of unknown numbers: a NaN would spoil all that it is added to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot.tracking import LOST, Candidates, Forecast


def finite_candidates(candidates: Candidates) -> Candidates:
    """The candidates of which place and blobs are known; the same message if all are."""
    numbers = candidates.xyz, candidates.area, candidates.xy
    if all(np.isfinite(column).all() for column in numbers):
        return candidates
    known = [np.isfinite(column).reshape(len(column), -1).all(axis=1) for column in numbers]
    return candidates.where(np.logical_and.reduce(known))


def finite_forecast(forecast: Forecast | None) -> Forecast | None:
    """The forecast, in which a target without a known place is lost; the same message if all are known."""
    if forecast is None:
        return None
    numbers = np.isfinite(forecast.xyz), np.isfinite(forecast.covariance)
    if all(column.all() for column in numbers):
        return forecast
    known = np.asarray(numbers[0].all(axis=1) & numbers[1].all(axis=(1, 2)))
    return replace(
        forecast,
        state=np.where(known, forecast.state, LOST).astype(np.uint8),
        xyz=np.where(known[:, None], forecast.xyz, 0.0),
        covariance=np.where(known[:, None, None], forecast.covariance, 0.0),
    )
