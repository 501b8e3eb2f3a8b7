"""Fusion of 3D candidates by mean shift (Jin & Qian 2008, section 3.6)."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.tracking import Candidates, Forecast, Positions
from followspot_balls.kernels import epipolar_weight, kernel
from followspot_balls.search import lost_targets


class MeanShift(Stage):
    """Seek the mode of each target's candidates, from the forecast; a lost target's from the densest one."""

    class Params(StageParams):
        bandwidth: float = Field(
            3.0,
            gt=0,
            unit="1",
            description="bandwidth over the forecast's sigma; raising it averages more candidates",
        )
        smallest: float = Field(0.04, gt=0, unit="m", description="smallest bandwidth")
        lost: float = Field(0.1, gt=0, unit="m", description="bandwidth for a target without forecast")
        epipolar: float = Field(
            3.0, gt=0, unit="px", description="T_ED of the weights; lowering it trusts exact pairs more"
        )
        tolerance: float = Field(0.0005, gt=0, unit="m", description="converged when a step is shorter")
        steps: int = Field(30, gt=0, unit="1", description="most steps")

    params: Params

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Positions:
        weights = epipolar_weight(candidates.epipolar, self.params.epipolar) * candidates.targets.T
        lost = lost_targets(forecast, len(weights))
        weights[lost] *= (weights[lost] * candidates.confirmed).any(axis=1, keepdims=True)
        target = np.flatnonzero(weights.any(axis=1))
        weights, lost = weights[target], lost[target]
        bandwidth = self.bandwidth(forecast, target, lost)
        start = self.start(candidates, weights, bandwidth, forecast, target, lost)
        xyz, kernels, steps = shift_to_modes(
            start,
            bandwidth,
            candidates.xyz,
            candidates.labelled,
            weights,
            self.params.tolerance,
            self.params.steps,
        )
        used = kernels > 0
        return Positions(
            target=target.astype(np.int32),
            xyz=xyz,
            covariance=np.full((len(target), 3, 3), np.nan),
            support=used.sum(axis=1).astype(np.int32),
            confirmed=np.asarray((used & candidates.confirmed).any(axis=1)),
            iterations=steps.astype(np.int32),
        )

    def bandwidth(self, forecast: Forecast | None, target: Array, lost: Array) -> Array:
        """Ellipsoid h = s sqrt(diag P) with a floor, (M, 3) m."""
        h = np.full((len(target), 3), self.params.lost)
        if forecast is not None and not lost.all():
            variance = np.diagonal(forecast.covariance[target[~lost]], axis1=1, axis2=2)
            h[~lost] = np.maximum(self.params.bandwidth * np.sqrt(variance), self.params.smallest)
        return h

    def start(
        self,
        candidates: Candidates,
        weights: Array,
        bandwidth: Array,
        forecast: Forecast | None,
        target: Array,
        lost: Array,
    ) -> Array:
        """Initial centres, (M, 3) m."""
        center = np.zeros((len(target), 3))
        if forecast is not None and not lost.all():
            center[~lost] = forecast.xyz[target[~lost]]
        for row in np.flatnonzero(lost):
            seed = candidates.xyz[(weights[row] > 0) & candidates.confirmed]
            offsets = candidates.xyz - seed[:, None]
            h = np.broadcast_to(bandwidth[row], (len(seed), 3))
            density = (kernel(offsets, h, candidates.labelled) * weights[row]).sum(axis=1)
            center[row] = seed[density.argmax()]
        return center


def shift_to_modes(
    center: Array, bandwidth: Array, xyz: Array, labelled: Array, weights: Array, tolerance: float, steps: int
) -> tuple[Array, Array, Array]:
    """Move each centre to the weighted mean of what its kernel holds (eq. 4) until it rests.

    An empty kernel at the start is put on the weighted mean of all its candidates.
    center, bandwidth: (M, 3) m; xyz: (N, 3) m; labelled: (N,) bool; weights: (M, N), each row with one
    above 0; tolerance: m. Returns centres (M, 3), weighted kernels (M, N), steps taken (M,).
    """
    center = center.copy()
    taken = np.zeros(len(center), int)
    values = weights
    for step in range(1, steps + 1):
        values = kernel(xyz - center[:, None], bandwidth, labelled) * weights
        total = values.sum(axis=1)
        empty = total == 0
        values[empty] = weights[empty]
        mean = (values @ xyz) / values.sum(axis=1, keepdims=True)
        moved = np.linalg.norm(mean - center, axis=1)
        center = mean
        moving = moved >= tolerance
        taken[moving | (taken == step - 1)] = step
        if not moving.any():
            break
    return center, values, taken
