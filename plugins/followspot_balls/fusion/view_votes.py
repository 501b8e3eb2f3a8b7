"""Votes of the views: which candidate of a target lies where all views together make the target likeliest.

Candidates that agree are no independent evidence, as one blob makes several; views are.
"""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Room
from followspot_balls.fusion.blob_assignment import Claims, shares, squared_errors
from followspot_balls.fusion.blob_params import BlobParams
from followspot_balls.measurement.points import point_images


class VoteParams(BlobParams):
    """How views vote for candidates."""

    vote_scale: float = Field(
        1.0,
        gt=0,
        unit="px",
        description="error in the picture at which the density of a whole blob is half its largest; raising "
        "it tolerates bad calibration",
    )
    vote_clutter: float = Field(
        0.05,
        gt=0,
        unit="1",
        description="density of clutter over the largest of a whole blob; raising it lets a few exact views "
        "outvote several inexact ones",
    )
    color_vote_bonus: float = Field(
        0.5,
        ge=0,
        unit="1",
        description="extra weight of colour cameras in the vote for the candidate at which the fusion "
        "begins; raising it helps in crowds",
    )
    prior_sigma: float = Field(
        0.1,
        gt=0,
        unit="m",
        description="sigma of that candidate around the forecast; raising it lets targets jump",
    )


class ViewVotes:
    """The cameras of a room as voters."""

    def __init__(self, room: Room, params: VoteParams) -> None:
        cameras = room.cameras.values()
        self.params = params
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.voice = 1 + params.color_vote_bonus * np.array([c.kind == "color" for c in cameras], bool)

    def prior(self, xyz: Array, forecast: Array) -> Array:
        """Logarithm of the prior of places (N, 3) m as those of targets with forecasts (M, 3) m: (M, N)."""
        off = xyz - forecast[:, None]
        return np.asarray(-np.vecdot(off, off) / (2 * self.params.prior_sigma**2))

    def posterior(self, xyz: Array, prior: Array, claims: Claims) -> Array:
        """Logarithm of the posterior of each place as that of each target: (M, N).

        The views are independent, so their densities multiply: several that agree on a place outvote two that
        fit another one better, and a forecast that is off by a ball's width. A blob is a target's by a
        Cauchy density whose squared width, px^2, grows with the sigma of its centre: a fragment supports an
        exact place less than a whole blob does, and contradicts a near one less. Else it lies there by
        chance.
        xyz: (N, 3) m; prior: (M, N) logarithms, -inf for places that are not in question.
        """
        p = self.params
        row, place = np.nonzero(prior > -np.inf)
        seen = point_images(self.P, xyz[place])
        squares = squared_errors(claims.xy, seen, claims.possible[row])
        share = shares(claims, seen.depth, row)
        sigma = np.sqrt(p.center_variance(share))
        width2 = p.vote_scale**2 / p.blob_sigma * sigma
        density = np.sqrt(width2) / (width2 + squares)
        nearest = np.ascontiguousarray(density.transpose(2, 0, 1)).max(axis=0)  # five times as fast as axis=2
        found = prior.copy()
        found[row, place] += np.log1p(nearest / p.vote_clutter) @ self.voice
        return found
