"""Mean shift from the forecast, and nothing more (Jin & Qian 2008, section 3.6, eq. 4-8)."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.tracking import Candidates, Forecast, Positions
from followspot_balls.fusion.kernels import epipolar_weight
from followspot_balls.fusion.modes import Sample, densest, seek_modes
from followspot_balls.scene.targets import lost_targets


class PlainMeanShift(Stage):
    """Seek the mode of each target's candidates from the forecast, as published.

    The paper does not say where a lost target's centre starts: here it is the densest candidate. A target
    whose kernel holds no candidate has no position.
    """

    advice = "no colour and infrared camera see a target at once, or the forecast's sigma is too small"

    class Params(StageParams):
        bandwidth_scale: float = Field(
            1.0,
            gt=0,
            unit="1",
            description="bandwidth over the forecast's sigma; raising it averages more candidates",
        )
        minimum_bandwidth: float = Field(
            0.001,
            gt=0,
            unit="m",
            description="smallest bandwidth; raising it includes more biased candidates",
        )
        lost_bandwidth: float = Field(
            0.1,
            gt=0,
            unit="m",
            description="bandwidth for a lost target; raising it averages more candidates",
        )
        epipolar_sigma: float = Field(
            3.0,
            gt=0,
            unit="px",
            description="T_ED, sigma of the epipolar distance; lowering it prefers precise pairs",
        )
        convergence_distance: float = Field(
            0.0005, gt=0, unit="m", description="step of a centre that has converged; raising it saves time"
        )
        maximum_iterations: int = Field(
            30, gt=0, unit="1", description="largest number of steps of a centre; raising it costs time"
        )

    params: Params

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Positions:
        p = self.params
        lost = lost_targets(forecast, candidates.targets.shape[1])
        weights = epipolar_weight(candidates.epipolar, p.epipolar_sigma) * candidates.targets.T
        target = np.flatnonzero(weights.any(axis=1))
        start, bandwidth = self.kernels(target, lost[target], forecast)
        sample = Sample(candidates.xyz, candidates.labelled, weights[target], bandwidth)
        sought = lost[target]
        if sought.any():
            some = sample.rows(sought)
            start[sought] = densest(some, np.ones_like(some.weights))
        modes = seek_modes(start, sample, p.convergence_distance, p.maximum_iterations)
        used = modes.held > 0
        filled = np.flatnonzero(used.any(axis=1))
        xyz, steps = modes.center[filled], modes.steps[filled]
        return Positions.fused(candidates, target[filled], used[filled], xyz, iterations=steps)

    def kernels(self, target: Array, lost: Array, forecast: Forecast | None) -> tuple[Array, Array]:
        """Initial centres and bandwidths of some targets: (M, 3) m each.

        The bandwidth is a length, so it comes from the square roots of the covariance's diagonal.
        target: (M,) numbers; lost: (M,) bool, which of these have no forecast.
        """
        p = self.params
        start, bandwidth = np.zeros((len(target), 3)), np.full((len(target), 3), p.lost_bandwidth)
        if forecast is not None and not lost.all():
            known = target[~lost]
            sigma = np.sqrt(forecast.covariance.diagonal(axis1=1, axis2=2)[known])
            start[~lost] = forecast.xyz[known]
            bandwidth[~lost] = np.maximum(p.bandwidth_scale * sigma, p.minimum_bandwidth)
        return start, bandwidth
