"""Fusion of 3D candidates by mean shift (Jin & Qian 2008, section 3.6)."""

from __future__ import annotations

from typing import Literal

import numpy as np

from followspot import Array, Field, Latest
from followspot.tracking import Candidates, Forecast, Positions
from followspot_balls.association.recovery_evidence import appearing, recovery_credit
from followspot_balls.fusion.kernels import epipolar_weight
from followspot_balls.fusion.mode_covariance import ModeCovariance, rivals_covariance
from followspot_balls.fusion.modes import Modes, Sample, densest, seek_modes, weighted_mean
from followspot_balls.fusion.validation import Fusion
from followspot_balls.measurement.blob_table import blob_table
from followspot_balls.pairs.camera_numbers import numbered
from followspot_balls.scene.targets import lost_targets

FAINT = 1e-200
"""Smallest credit of a candidate, so that a distant one can be chosen if there is no other."""


class MeanShift(Fusion):
    """Seek the mode of each target's candidates, from the forecast or from the densest candidate.

    The position is the mean of the candidates in the mode, weighted by the kernel and by the precision of the
    candidates: fragments, and blobs merged with other light, are less precise than fully visible balls. A
    lost target has a wide mode, whose candidates count without precision, because other things in it may look
    as complete as the ball.
    """

    class Params(Fusion.Params):
        """Start and bandwidth of the modes, and the weights of candidates."""

        initial_center: Literal["forecast", "densest", "mean"] = Field(
            "forecast", description="initial centre of a target with a forecast"
        )
        bandwidth_scale: float = Field(
            2.5,
            gt=0,
            unit="1",
            description="bandwidth over the forecast's sigma; raising it averages more candidates",
        )
        minimum_bandwidth: float = Field(
            0.03, gt=0, unit="m", description="smallest bandwidth; raising it includes more biased candidates"
        )
        lost_bandwidth: float = Field(
            0.1,
            gt=0,
            unit="m",
            description="bandwidth for a lost target; raising it recovers more targets, also falsely",
        )
        epipolar_sigma: float = Field(
            1.0,
            gt=0,
            unit="px",
            description="sigma of the epipolar distance (T_ED); lowering it prefers precise pairs",
        )
        recovery_epipolar_sigma: float = Field(
            3.0,
            gt=0,
            unit="px",
            description="sigma of the epipolar distance for candidates of a lost target that three views "
            "show; raising it recovers more",
        )
        minimum_mode_share: float = Field(
            0.8,
            ge=0,
            le=1,
            unit="1",
            description="share of all weight that the mode at the forecast must exceed; otherwise the mode "
            "at the candidate that all views make likeliest replaces it; raising it leaves wrong forecasts "
            "sooner",
        )
        minimum_support_weight: float = Field(
            0.6,
            ge=0,
            lt=1,
            unit="1",
            description="smallest weight of a candidate that counts as support; raising it avoids mistakes",
        )
        convergence_distance: float = Field(
            0.0005, gt=0, unit="m", description="step of a centre that has converged; raising it saves time"
        )
        maximum_iterations: int = Field(
            30, gt=0, unit="1", description="largest number of steps of a centre; raising it costs time"
        )

        depth_sigma: float = Field(
            0.008,
            gt=0,
            unit="m",
            description="sigma of a position from a single depth camera; raising it smooths more",
        )
        rival_exponent: float = Field(
            4.0,
            gt=0,
            unit="1",
            description="exponent k of (weight of rivals / weight of the mode)^k, the odds that the rivals "
            "are right; raising it trusts majorities more",
        )

    params: Params

    def setup(self) -> None:
        super().setup()
        self.covariance = ModeCovariance(self.room, self.params, self.params.depth_sigma)

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Positions:
        candidates = numbered(candidates, self.cameras)
        lost = lost_targets(forecast, candidates.targets.shape[1])
        threshold = self.threshold(candidates, lost)
        weights = epipolar_weight(candidates.epipolar, threshold) * candidates.targets.T
        there = np.asarray(weights.any(axis=1))
        if np.count_nonzero(lost):
            there &= (candidates.targets.T & candidates.confirmed).any(axis=1) | ~lost
        target = there.nonzero()[0]
        weights, lost = weights.take(target, axis=0), lost.take(target)
        center, sigma = expectation(forecast, target, lost)
        bandwidth = np.maximum(self.params.bandwidth_scale * sigma, self.params.minimum_bandwidth)
        bandwidth[lost] = self.params.lost_bandwidth
        sample = Sample(candidates.xyz, candidates.labelled, weights, bandwidth)
        modes = self.modes(sample, center, candidates, target, lost)
        precision = self.covariance.precision(candidates, target)
        precision[bandwidth.max(axis=1) >= self.params.lost_bandwidth] = 1.0
        held = modes.held * precision
        place = weighted_mean(candidates.xyz, held)
        used = modes.held > self.params.minimum_support_weight
        support = used.sum(axis=1, dtype=np.int32)
        shown = np.where((support > 0)[:, None], used, modes.held > 0)
        positions = Positions(
            target=target.astype(np.int32),
            xyz=place,
            covariance=self.covariance.of(candidates, target, place, held)
            + rivals_covariance(candidates.xyz, place, weights, modes, self.params.rival_exponent),
            support=support,
            confirmed=np.asarray((used & candidates.confirmed).any(axis=1)),
            evident=np.asarray((shown & candidates.evident).any(axis=1)),
            iterations=modes.steps.astype(np.int32),
            predicted=np.zeros(len(target), bool),
        )
        return self.validated(positions, candidates, forecast)

    def threshold(self, candidates: Candidates, lost: Array) -> Array | float:
        """T_ED, px: of all candidates, or (T, N) if a target has no forecast."""
        p = self.params
        if not np.count_nonzero(lost):
            return p.epipolar_sigma
        return np.where(appearing(candidates, lost).T, p.recovery_epipolar_sigma, p.epipolar_sigma)

    def credit(self, candidates: Candidates, center: Array, lost: Array) -> Array:
        """Factor of the candidates' densities: from their distance to the forecast, or from their evidence.

        center: (M, 3) m; lost: (M,). Returns (M, N).
        """
        near = np.exp(self.votes.prior(candidates.xyz, center))
        return np.where(lost[:, None], recovery_credit(candidates), np.maximum(near, FAINT))

    def modes(
        self, sample: Sample, center: Array, candidates: Candidates, target: Array, lost: Array
    ) -> Modes:
        """Modes from the initial centres; from the likeliest candidates if those modes have little weight.

        center: (M, 3) m; target: (M,); lost: (M,) bool.
        """
        p = self.params
        start = weighted_mean(sample.xyz, sample.weights) if p.initial_center == "mean" else center.copy()
        dense = lost | (p.initial_center == "densest")
        if np.count_nonzero(dense):
            credit = self.credit(candidates, center[dense], lost[dense])
            start[dense] = densest(sample.rows(dense), credit)
        first = seek_modes(start, sample, p.convergence_distance, p.maximum_iterations)
        poor = ~dense & (first.total <= p.minimum_mode_share * sample.weights.sum(axis=1))
        if not np.count_nonzero(poor):
            return first
        rest = sample.rows(poor)
        start = self.likeliest(rest, center[poor], candidates, target[poor])
        second = seek_modes(start, rest, p.convergence_distance, p.maximum_iterations)
        for old, new in zip(first, second, strict=True):
            old[poor] = new
        return first

    def likeliest(self, sample: Sample, center: Array, candidates: Candidates, target: Array) -> Array:
        """The candidates that all views and the forecasts make likeliest: (M, 3) m.

        center: (M, 3) m, the forecasts; target: (M,).
        """
        prior = np.where(sample.weights > 0, self.votes.prior(sample.xyz, center), -np.inf)
        table = blob_table(candidates, len(self.cameras))
        claims = self.claims(table, target, np.zeros(len(target), bool))
        best = self.votes.posterior(sample.xyz, prior, claims).argmax(axis=1)
        return np.asarray(sample.xyz.take(best, axis=0))


def expectation(forecast: Forecast | None, target: Array, lost: Array) -> tuple[Array, Array]:
    """Forecast place and sigma along each axis, (M, 3) m each; zero for lost targets."""
    if forecast is None or np.count_nonzero(lost) == lost.size:
        return np.zeros((len(target), 3)), np.zeros((len(target), 3))
    variance = forecast.covariance.diagonal(axis1=1, axis2=2)
    known = ~lost[:, None]
    return forecast.xyz.take(target, axis=0) * known, np.sqrt(variance.take(target, axis=0) * known)
