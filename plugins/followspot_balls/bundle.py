"""Robust maximum-likelihood fusion over all views, with its covariance: better than pairs and their mode."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from followspot import Array, Field, Latest, Stage, StageParams
from followspot.tracking import Candidates, Forecast, Positions
from followspot_balls.bundle_assignment import Claims, assigned, shares, squared_errors
from followspot_balls.bundle_glow import glow_sigma, nearest_planes
from followspot_balls.bundle_points import (
    PARAMETERS,
    Belief,
    Equations,
    Model,
    Views,
    covariance,
    glowing_model,
    images,
    linearised,
    point_images,
    solved,
    weighted,
)
from followspot_balls.bundle_sightings import sightings
from followspot_balls.bundle_trust import Outlines, variance
from followspot_balls.search import lost_targets

USED = 0.25
"""Weight above which a view counts as support: that of an error at the cutoff."""
VAGUE = 1e-3
"""Least information on a place, 1/m^2: keeps equations of views that do not determine it solvable."""
DARK = 1e-6
"""Least sigma of the glow, m: far from every plane there is none."""
ROUNDS, STEPS = 2, 3
"""Times that blobs are assigned to targets, and steps after each."""


class Fit(NamedTuple):
    """Places of M targets and what they rest on."""

    xyz: Array
    """(M, 3) m."""
    covariance: Array
    """(M, 3, 3) m^2."""
    equations: Equations
    slot: Array
    """(M, C) blob of each target in each view."""


class Bundle(Stage):
    """Minimise the robust reprojection error of each target over all cameras, one blob in each."""

    class Params(StageParams):
        sigma: float = Field(
            0.2, gt=0, unit="px", description="one sigma of a whole ball's centre; raising it smooths more"
        )
        hidden: float = Field(
            4.0,
            ge=0,
            unit="1",
            description="sigmas by which that of a wholly hidden ball would be larger; raising it trusts "
            "small blobs less",
        )
        merged: float = Field(
            2.0,
            ge=0,
            unit="1",
            description="sigmas by which that of a blob twice the ball's size is larger; raising it trusts "
            "large blobs less",
        )
        agreement: float = Field(
            1.0,
            gt=0,
            unit="px",
            description="scale of the error at which views agree in the search for a start; raising it "
            "survives a poor calibration",
        )
        cutoff: float = Field(
            3.0,
            gt=0,
            unit="1",
            description="sigmas at which a view keeps a quarter of its weight; raising it rejects less",
        )
        prior: float = Field(
            0.1,
            gt=0,
            unit="m",
            description="one sigma of the start's distance from the forecast; raising it lets targets jump",
        )
        forecast: float = Field(
            0.3,
            ge=0,
            unit="1",
            description="weight of the forecast in judging which views to trust; it does not enter the "
            "position; raising it leaves wrong forecasts later",
        )
        sharpest: float = Field(
            0.004,
            ge=0,
            unit="m",
            description="one sigma added to the forecast's; raising it trusts sharp forecasts less",
        )
        glow: float = Field(
            0.02,
            ge=0,
            unit="m",
            description="one sigma by which the light of a ball on a plane draws its centre there in colour "
            "cameras; raising it trusts them less along the normal",
        )
        reach: float = Field(
            0.12, gt=0, unit="m", description="clearance from the plane in which that falls to a third"
        )
        certainty: float = Field(
            4.0,
            gt=0,
            unit="1",
            description="errors that the sigma counts for in the covariance; raising it heeds those of the "
            "frame less",
        )

    params: Params

    def setup(self) -> None:
        cameras = list(self.room.cameras.values())
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.planes = np.array(list(self.room.planes.values())).reshape(-1, 4)
        self.radii = np.array([t.radius for t in self.room.targets.values()])
        self.outlines = Outlines(self.room)

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Positions:
        lost = lost_targets(forecast, len(self.radii))
        seeds = candidates.targets.T & (candidates.confirmed | ~lost[:, None])
        target = np.flatnonzero(seeds.any(axis=1))
        if not len(target):
            return Positions.empty()
        table = sightings(candidates, len(self.P))
        sizes = self.outlines.at_unit_depth(table.xy, table.area)
        claims = Claims(table.xy, table.targets[target], sizes, self.radii[target], lost[target])
        credit = seeds[target] * self.credit(candidates.xyz, target, claims.lost, forecast)
        start = candidates.xyz[self.votes(candidates.xyz, credit, claims).argmax(axis=1)]
        fit = self.refined(start, claims, self.expectation(target, claims.lost, forecast))
        chosen = fit.slot[:, candidates.view] == table.slot
        trusted = fit.equations.trust[:, candidates.view] > USED
        used = (chosen & trusted).all(axis=2) & candidates.targets.T[target]
        return Positions(
            target=target.astype(np.int32),
            xyz=fit.xyz,
            covariance=fit.covariance,
            support=used.sum(axis=1).astype(np.int32),
            confirmed=np.asarray((used & candidates.confirmed).any(axis=1)),
            iterations=np.full(len(target), ROUNDS * STEPS, np.int32),
        )

    def credit(self, xyz: Array, target: Array, lost: Array, forecast: Forecast | None) -> Array:
        """Factor of the candidates' votes by their distance from the forecasts: (N, 3) m -> (M, N)."""
        if forecast is None or lost.all():
            return np.ones((len(target), len(xyz)))
        distance2 = np.square(xyz - forecast.xyz[target][:, None]).sum(axis=2)
        return np.where(lost[:, None], 1.0, np.exp(-distance2 / (2 * self.params.prior**2)))

    def votes(self, xyz: Array, credit: Array, claims: Claims) -> Array:
        """How well all views agree with each candidate, as a place of each target: (M, N).

        xyz: (N, 3) m; credit: (M, N) factors, 0 for candidates that are not in question.
        """
        row, candidate = np.nonzero(credit)
        seen = point_images(self.P, xyz[candidate])
        squares = squared_errors(claims.xy, seen, claims.possible[row])
        exactness = 1 / np.sqrt(self.variance(shares(claims, seen.depth, row)))
        agreement = exactness / (1 + squares / self.params.agreement**2)
        votes = np.zeros(credit.shape)
        votes[row, candidate] = agreement.max(axis=2).sum(axis=1) * credit[row, candidate]
        return votes

    def variance(self, share: Array) -> Array:
        """Of centres whose blobs show these shares of their outlines, px^2."""
        p = self.params
        return variance(share, p.sigma, p.hidden, p.merged)

    def expectation(self, target: Array, lost: Array, forecast: Forecast | None) -> Belief:
        """The forecast of each target's place, with part of its information; none of lost targets."""
        mean, information = (
            np.zeros((len(target), PARAMETERS)),
            np.zeros((len(target), PARAMETERS, PARAMETERS)),
        )
        if forecast is not None and not lost.all():
            known = target[~lost]
            mean[~lost, :3] = forecast.xyz[known]
            spread = forecast.covariance[known] + np.eye(3) * self.params.sharpest**2
            information[~lost, :3, :3] = self.params.forecast * np.linalg.inv(spread)
        return Belief(mean, information)

    def glow(self, xyz: Array, radius: Array) -> tuple[Model, Belief]:
        """The model of glowing balls near these places (M, 3) m, and what is known of the glow."""
        normal, clearance = nearest_planes(self.planes, xyz, radius)
        sigma = np.maximum(glow_sigma(clearance, self.params.glow, self.params.reach), DARK)
        information = np.zeros((len(xyz), PARAMETERS, PARAMETERS))
        information[:, [0, 1, 2], [0, 1, 2]] = VAGUE
        information[:, 3, 3] = 1 / np.square(sigma)
        mean = np.column_stack([xyz, np.zeros(len(xyz))])
        return glowing_model(self.P, normal, self.color), Belief(mean, information)

    def refined(self, start: Array, claims: Claims, expected: Belief) -> Fit:
        """The most likely places, from nearby ones: (M, 3) m.

        The forecast helps to judge the views, for two that disagree cannot judge each other; the place
        comes from the views alone, because the filter adds the forecast itself.
        """
        p = self.params
        model, glow = self.glow(start, claims.radius)
        base, step = glow.mean, np.zeros((len(start), PARAMETERS))
        row, camera = np.arange(len(start)), np.arange(len(self.P))
        for scale in (p.agreement, p.cutoff * p.sigma):
            base = base + step
            seen = images(model, base)
            slot, found = assigned(claims, seen)
            spread = self.variance(shares(claims, seen.depth, row, slot))
            views = Views(claims.xy[camera, slot], found / spread, scale**2 * np.sqrt(spread) / p.sigma)
            J, errors = linearised(model, seen, views)
            step = np.zeros_like(base)
            for _ in range(STEPS):
                step = solved(weighted(J, errors, step, views), base, glow, expected)
        equations = weighted(J, errors, step, views)
        place = base + solved(equations, base, glow)
        return Fit(place[:, :3], covariance(equations, glow, p.certainty), equations, slot)
