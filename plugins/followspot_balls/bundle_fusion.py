"""Robust maximum-likelihood fusion over all views, with its covariance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array, Field, Latest
from followspot.tracking import Candidates, Forecast, Positions
from followspot_balls.association.recovery_evidence import DOUBTED, appearing
from followspot_balls.fusion.blob_assignment import Claims, assigned, shares
from followspot_balls.fusion.contradiction import contradicted
from followspot_balls.fusion.validation import Fusion
from followspot_balls.measurement.blob_table import blob_table
from followspot_balls.measurement.glow_shift import glow_sigma
from followspot_balls.measurement.points import (
    PARAMETERS,
    Belief,
    Projection,
    Views,
    empty_belief,
    estimated,
    glowing_projection,
    images,
    linearised,
    solved,
    weighted,
)
from followspot_balls.pairs.camera_numbers import numbered
from followspot_balls.scene.bounding_planes import nearest_planes
from followspot_balls.scene.targets import lost_targets

USED = 0.4
"""Weight above which a view counts as support: the weight of an error of three quarters of the cutoff."""
VAGUE = 1e-3
"""Smallest information on a position, 1/m^2: keeps underdetermined equations solvable."""
PLACE = [0, 1, 2]
DARK = 1e-6
"""Smallest sigma of the glow, m, far from all planes."""
STEPS = 3
"""Iterations of reweighted least squares; one linearisation suffices, because the start is a candidate."""


class Fit(NamedTuple):
    """Fitted positions of M targets, with the views that support them."""

    xyz: Array
    """(M, 3) m."""
    covariance: Array
    """(M, 3, 3) m^2."""
    trust: Array
    """(M, C) robust weight of each view, 0 if there is none."""
    slot: Array
    """(M, C) blob of each target in each view."""


class Bundle(Fusion):
    """Minimise the robust reprojection error of each target over all cameras, one blob in each."""

    class Params(Fusion.Params):
        """Outliers, and the weight of the forecast."""

        outlier_cutoff: float = Field(
            4.0,
            gt=0,
            unit="sigma",
            description="error at which a view has a quarter of its weight; raising it rejects fewer views",
        )
        recovery_cutoff_scale: float = Field(
            3.0,
            gt=0,
            unit="1",
            description="factor on the cutoff for a lost target that three views show; raising it recovers "
            "more",
        )
        forecast_weight: float = Field(
            0.3,
            ge=0,
            unit="1",
            description="weight of the forecast when views are rejected; raising it keeps wrong forecasts "
            "longer",
        )
        added_forecast_sigma: float = Field(
            0.004,
            ge=0,
            unit="m",
            description="sigma added to the forecast's; raising it trusts precise forecasts less",
        )
        contradiction_exponent: float = Field(
            10.0,
            gt=0,
            unit="1",
            description="exponent k of (rejected weight / accepted weight)^k, the odds that the rejected "
            "views are right; raising it trusts majorities more",
        )

    params: Params

    def setup(self) -> None:
        super().setup()
        cameras = list(self.room.cameras.values())
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.planes = np.array(list(self.room.planes.values())).reshape(-1, 4)

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Positions:
        candidates = numbered(candidates, self.cameras)
        lost = lost_targets(forecast, candidates.targets.shape[1])
        seeds = candidates.targets.T & (candidates.confirmed | ~lost[:, None])
        target = np.flatnonzero(seeds.any(axis=1))
        if not len(target):
            return Positions.empty()
        table = blob_table(candidates, len(self.P))
        claims = self.claims(table, target, lost[target])
        prior = np.where(seeds[target], self.prior(candidates, target, claims.lost, forecast), -np.inf)
        start = candidates.xyz[self.votes.posterior(candidates.xyz, prior, claims).argmax(axis=1)]
        expected = self.expectation(target, claims.lost, forecast)
        fit = self.refined(start, claims, expected, self.cutoff(candidates, target, lost))
        agreeing = (fit.slot[:, candidates.view] == table.slot) & (fit.trust[:, candidates.view] > USED)
        used = agreeing.all(axis=2) & candidates.targets.T[target]
        positions = Positions.fused(candidates, target, used, fit.xyz, fit.covariance, STEPS)
        seen = positions if used.any(axis=1).all() else positions.where(positions.support > 0)
        return self.validated(seen, candidates, forecast)

    def prior(self, candidates: Candidates, target: Array, lost: Array, forecast: Forecast | None) -> Array:
        """Logarithm of each candidate's prior, (M, N): by its distance to the forecast, or by its evidence.

        target: (M,); lost: (M,) bool, which have no forecast.
        """
        evidence = np.log(np.where(candidates.evident, 1.0, DOUBTED))
        if forecast is None or lost.all():
            return np.broadcast_to(evidence, (len(target), len(evidence)))
        near = self.votes.prior(candidates.xyz, forecast.xyz[target])
        return np.where(lost[:, None], evidence, near)

    def cutoff(self, candidates: Candidates, target: Array, lost: Array) -> Array | float:
        """The outlier cutoff in sigmas: of all targets, or (M, 1) if one has no forecast. lost: (T,) bool."""
        p = self.params
        if not lost.any():
            return p.outlier_cutoff
        wide = np.asarray(appearing(candidates, lost).any(axis=0))[target]
        return np.where(wide, p.recovery_cutoff_scale * p.outlier_cutoff, p.outlier_cutoff)[:, None]

    def expectation(self, target: Array, lost: Array, forecast: Forecast | None) -> Belief:
        """The forecast of each target's position with a reduced weight; uninformative for lost targets."""
        vector, information = empty_belief(len(target))
        if forecast is not None and not lost.all():
            known = target[~lost]
            spread = forecast.covariance[known] + np.eye(3) * self.params.added_forecast_sigma**2
            try:
                weight = self.params.forecast_weight * np.linalg.inv(spread)
            except np.linalg.LinAlgError:  # a covariance that is none says nothing
                return Belief(vector, information)
            information[~lost, :3, :3] = weight
            vector[~lost, :3] = (weight @ forecast.xyz[known, :, None])[..., 0]
        return Belief(vector, information)

    def glow(self, xyz: Array, radius: Array) -> tuple[Projection, Belief]:
        """The projection of glowing balls near these positions (M, 3) m, and the prior of their glow."""
        normal, clearance = nearest_planes(self.planes, xyz, radius)
        sigma = glow_sigma(np.maximum(clearance, 0.0), self.params.glow_sigma, self.params.glow_range)
        vector, information = empty_belief(len(xyz))
        information[:, PLACE, PLACE] = VAGUE
        information[:, 3, 3] = 1 / np.square(np.maximum(sigma, DARK))
        vector[:, :3] = VAGUE * xyz
        vector[:, 3] = -self.params.glow_mean * sigma * information[:, 3, 3]
        return glowing_projection(self.P, normal, self.color), Belief(vector, information)

    def refined(self, start: Array, claims: Claims, expected: Belief, cutoff: Array | float) -> Fit:
        """The most likely positions, from nearby starts (M, 3) m.

        The forecast helps to judge the views, for two that disagree cannot judge each other; the place
        comes from the views alone, because the filter adds the forecast itself.
        cutoff: sigmas at which a view keeps a quarter of its weight.
        """
        p = self.params
        projection, glow = self.glow(start, claims.radius)
        row, camera = np.arange(len(start)), np.arange(len(self.P))
        origin = np.zeros((len(start), PARAMETERS))
        origin[:, :3] = start
        seen = images(projection, origin)
        slot, found = assigned(claims, seen)
        spread = self.params.center_variance(shares(claims, seen.depth, row, slot))
        views = Views(claims.xy[camera, slot], found / spread, cutoff**2 * p.blob_sigma * np.sqrt(spread))
        design = linearised(projection, seen, views)
        glow = glow.relative(origin)
        belief = glow.and_also(expected.relative(origin))
        step = np.zeros_like(origin)
        for _ in range(STEPS):
            step = solved(weighted(design, step, views), belief)
        equations = weighted(design, step, views)
        covariance = contradicted(design, step, equations.trust, found, p.contradiction_exponent)
        step, known = estimated(equations, glow, p.prior_errors)
        covariance += known
        return Fit(start + step[:, :3], covariance, equations.trust, slot)
