"""Tracks and forecasts with the position fixes of inertial sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from followspot.inertial import PosedTracks
from followspot.tracking import LOST, Forecast, Tracks
from followspot_balls.inertial.fix import Fix

Fixes = Mapping[int, Fix]
"""Position fixes, by number of the target."""


def posed(tracks: Tracks, fixes: Fixes) -> PosedTracks:
    """The tracks with the fixes of their targets; orientations of other targets are NaN."""
    count = len(tracks.target)
    xyz, velocity, sigma = tracks.xyz.copy(), tracks.velocity.copy(), tracks.sigma.copy()
    quaternion, orientation_sigma = np.full((count, 4), np.nan), np.full(count, np.nan)
    for row, number in enumerate(tracks.target.tolist()):
        fix = fixes.get(number)
        if fix is not None:
            xyz[row], velocity[row], sigma[row] = fix.xyz, fix.velocity, fix.sigma
            quaternion[row], orientation_sigma[row] = fix.quaternion, fix.orientation_sigma
    return PosedTracks(tracks.target, tracks.state, xyz, velocity, sigma, quaternion, orientation_sigma)


def forecast_with_fixes(forecast: Forecast, tracks: Tracks, fixes: Fixes) -> Forecast:
    """The forecast with the fixes of targets that are tracked or predicted."""
    chosen = [number for number in tracks.target.tolist() if number in fixes]
    if not chosen:
        return forecast
    xyz, velocity = forecast.xyz.copy(), forecast.velocity.copy()
    covariance = forecast.covariance.copy()
    for number in chosen:
        xyz[number], velocity[number] = fixes[number].xyz, fixes[number].velocity
        covariance[number] = fixes[number].covariance
    return replace(forecast, xyz=xyz, velocity=velocity, covariance=covariance)


def searched_everywhere(forecast: Forecast, targets: Sequence[int]) -> Forecast:
    """The forecast with some targets, by number, searched everywhere as if they were lost."""
    kept = np.ones(len(forecast.state))
    kept[list(targets)] = 0.0
    row = kept[:, None]
    return replace(
        forecast,
        state=np.where(kept > 0, forecast.state, LOST).astype(np.uint8),
        xyz=forecast.xyz * row,
        velocity=forecast.velocity * row,
        covariance=forecast.covariance * row[..., None],
        last=forecast.last * row,
        before=forecast.before * row,
    )
