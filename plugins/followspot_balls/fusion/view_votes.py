"""Votes of the views: the candidate at whose position the blobs of all views make a target likeliest.

Candidates that agree are no independent evidence, because one blob makes several of them. Views are
independent.
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
        description="half width at half maximum of the error density (Cauchy) of a fully visible ball's "
        "blob; raising it tolerates bad calibration",
    )
    vote_clutter: float = Field(
        0.05,
        gt=0,
        unit="1",
        description="density of clutter over the peak of the error density of a fully visible ball's blob; "
        "raising it lets a few exact views outvote several inexact ones",
    )
    color_vote_bonus: float = Field(
        0.5,
        ge=0,
        unit="1",
        description="weight that a colour camera has beyond that of another camera (1) in the vote for the "
        "candidate at which the fusion begins; raising it helps in crowds",
    )
    prior_sigma: float = Field(
        0.1,
        gt=0,
        unit="m",
        description="sigma of the distance between the forecast and the candidate at which the fusion "
        "begins; raising it lets targets jump",
    )


class ViewVotes:
    """The cameras of a room as voters."""

    def __init__(self, room: Room, params: VoteParams) -> None:
        cameras = room.cameras.values()
        self.params = params
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.voice = 1 + params.color_vote_bonus * np.array([c.kind == "color" for c in cameras], bool)

    def prior(self, xyz: Array, forecast: Array) -> Array:
        """Logarithm of the prior of N positions, (N, 3) m, for M targets with forecasts (M, 3) m: (M, N)."""
        off = xyz - forecast[:, None]
        return np.asarray(-np.vecdot(off, off) / (2 * self.params.prior_sigma**2))

    def posterior(self, xyz: Array, prior: Array, claims: Claims) -> Array:
        """Logarithm of the posterior of each position for each target: (M, N).

        The views are independent, so their densities multiply: several views that agree on a position outvote
        two that fit another one better, and also a forecast that is off by a ball's width. The error of a
        target's blob has a Cauchy density, whose squared width, px^2, grows with the sigma of the blob's
        centre: a fragment supports an exact position less than a whole blob does, and contradicts a near one
        less. Other blobs are clutter of constant density.
        xyz: (N, 3) m; prior: (M, N) logarithms, -inf for positions that are not considered.
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
