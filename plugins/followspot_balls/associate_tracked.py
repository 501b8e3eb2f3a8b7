"""Association of tracked targets that few candidates show."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.tracking import Candidates, Forecast
from followspot_balls.association.existence import Existence
from followspot_balls.association.likelihood import ball_vs_reflector_log_ratio
from followspot_balls.association.view_association import ViewAssociation, WeighedHypotheses

SETTLED = 3
"""Candidates at the forecast of a target that determine its position."""
SETTLED_LOG_RATIO = 1.0
"""Log-likelihood ratio of such a frame, nats: little, as one colour blob on the ray to a reflector
makes as many."""
GATE = 3.0
"""Distance from the forecast up to which a candidate is at it, sigmas."""
NEAR = 0.03
"""The same if the forecast is more exact than a pair of blobs, m."""


class AssociateTracked(ViewAssociation):
    """Keep the candidates of a tracked target's likeliest position if fewer than three are at its forecast.

    All views count, also those that detect nothing there, as in `balls.associate`. No frame alone
    ends a track: its log-odds against a reflector do, for colour tells whose ball it is. Targets that are
    sought, or that three candidates show, keep all their candidates, for the fusion to weigh. If the room has
    depth cameras, all candidates stay, for the weighing of views does not know their measurements.
    """

    advice = "give the room more cameras that see each place, or lower silence_odds"

    def unweighed(self, candidates: Candidates, forecast: Forecast | None, tracked: Array) -> Array:
        """Targets without a track, and those whose position is settled: (T,) bool."""
        return ~tracked if forecast is None else ~tracked | self.settled(candidates, forecast)

    def settled(self, candidates: Candidates, forecast: Forecast) -> Array:
        """Which targets three candidates show at their forecasts, one of them in their colour: (T,) bool."""
        off = candidates.xyz[:, None] - forecast.xyz
        variance = forecast.covariance.diagonal(axis1=1, axis2=2).max(axis=1)
        there = candidates.targets & (np.vecdot(off, off) <= np.maximum(GATE**2 * variance, NEAR**2))
        own = candidates.labelled @ there if self.colored else True
        return np.asarray((there.sum(axis=0) >= SETTLED) & own)

    def unweighed_log_ratio(self) -> float:
        """Little, as candidates that agree are no independent evidence."""
        return SETTLED_LOG_RATIO

    def evidence_ratio(self, log_ratio: Array, occam: Array) -> Array:
        """Against a reflector: what colour cameras alone show may be a ball on the floor."""
        return ball_vs_reflector_log_ratio(log_ratio, self.color, occam)

    def left_out(self, found: WeighedHypotheses, best: int) -> bool:
        """No frame alone speaks against a track."""
        return False

    def without_track(
        self, number: int, found: WeighedHypotheses, forecast: Forecast | None, tracked: Array
    ) -> tuple[Existence, int]:
        """Log-odds of an interrupted track decay; those of a deleted one are forgotten."""
        odds = self.existence[number].odds
        if odds < self.rules.deletion:
            return Existence.unknown(), -1
        return Existence.unknown()._replace(odds=self.rules.memory ** self.steps(forecast) * odds), -1
