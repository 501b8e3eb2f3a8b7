"""Positions that are not measured by pairs of views, but predicted: from one view, or by inertial sensors."""

from __future__ import annotations

import numpy as np

from followspot.messages import Array
from followspot.tracking import Positions


def with_predicted(positions: Positions, target: Array, xyz: Array, covariance: Array) -> Positions:
    """The positions, with predicted ones in place of those of M targets: (M,), (M, 3) m, (M, 3, 3) m^2."""
    count = len(target)
    if not count:
        return positions
    positions = positions.where(~np.isin(positions.target, target))
    return Positions(
        target=np.concatenate([positions.target, target.astype(np.int32)]),
        xyz=np.concatenate([positions.xyz, xyz]),
        covariance=np.concatenate([positions.covariance, covariance]),
        support=np.concatenate([positions.support, np.zeros(count, np.int32)]),
        confirmed=np.concatenate([positions.confirmed, np.zeros(count, bool)]),
        evident=np.concatenate([positions.evident, np.zeros(count, bool)]),
        iterations=np.concatenate([positions.iterations, np.zeros(count, np.int32)]),
        predicted=np.concatenate([positions.predicted, np.ones(count, bool)]),
    )
