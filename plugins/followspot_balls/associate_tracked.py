"""Association of targets that few candidates show, or that candidates show at several positions."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.tracking import MISSING, Candidates, Forecast
from followspot_balls.association.existence import Existence, near
from followspot_balls.association.likelihood import ball_vs_reflector_log_ratio
from followspot_balls.association.view_association import ViewAssociation, WeighedHypotheses
from followspot_balls.scene.distances import squared_distances

SETTLED = 3
"""Candidates at the forecast of a target that determine its position."""
SETTLED_LOG_RATIO = 1.0
"""Log-likelihood ratio of such a frame, nats: little, as one colour blob on the ray to a reflector
makes as many."""
GATE = 3.0
"""Distance from the forecast up to which a candidate is at it, sigmas."""
MINIMUM_GATE = 0.03
"""The same in m, where the forecast is more exact than a pair of blobs."""
MINIMUM_LEAD = 1.0
"""Smallest lead of the likeliest of rival positions, nats; with less, all candidates stay, so that the
position of the fusion is vague."""


class AssociateTracked(ViewAssociation):
    """Keep the candidates of a tracked target's likeliest position if fewer than three are at its forecast.

    All views count, also those that detect nothing there, as in `balls.associate`. No frame alone
    ends a track: its log-odds against a reflector do, for colour tells whose ball it is. Near its last
    position it returns only if these rise again. If evident pairs show a target without a track at several
    positions, it keeps the candidates of the likeliest if that clearly leads. Other targets keep all their
    candidates, for the fusion to weigh. If the room has depth cameras, all candidates stay, for the weighing
    of views does not know their measurements.
    """

    advice = "give the room more cameras that see each place, or lower silence_odds"

    def unweighed(self, candidates: Candidates, forecast: Forecast | None, tracked: Array) -> Array:
        """Targets whose position is settled, and those without a track and without rivals: (T,) bool."""
        if forecast is not None and np.count_nonzero(tracked) == len(tracked):
            return self.settled(candidates, forecast)
        alone = ~self.with_rivals(candidates)
        if forecast is None:
            return alone
        alone &= ~self.given_up(forecast)
        return np.where(tracked, self.settled(candidates, forecast), alone)

    def given_up(self, forecast: Forecast) -> Array:
        """Which targets are missing because the views spoke against their tracks: (T,) bool."""
        deleted = np.array([len(one.rivals.odds) > 0 for one in self.existence], bool)
        return np.asarray(deleted & (forecast.state == MISSING))

    def with_rivals(self, candidates: Candidates) -> Array:
        """Which targets evident candidates show at positions farther apart than the reach: (T,) bool."""
        evident = candidates.evident.nonzero()[0]
        targets, xyz = candidates.targets.take(evident, axis=0), candidates.xyz.take(evident, axis=0)
        offset = xyz[:, None] - xyz
        apart = np.vecdot(offset, offset) > self.params.reach**2
        return np.asarray(((apart @ targets) & targets).any(axis=0))

    def settled(self, candidates: Candidates, forecast: Forecast) -> Array:
        """Which targets three candidates show at their forecasts, one of them in their colour: (T,) bool."""
        variance = forecast.covariance.diagonal(axis1=1, axis2=2).max(axis=1)
        reach2 = np.maximum(GATE**2 * variance, MINIMUM_GATE**2)[:, None]
        there = squared_distances(forecast.xyz, candidates.xyz) <= reach2
        there &= candidates.targets.T
        own = there @ candidates.labelled if self.colored else True
        return np.asarray((there.sum(axis=1) >= SETTLED) & own)

    def undecided(self, found: WeighedHypotheses, tracked: Array) -> Array:
        """Targets without a track whose likeliest position leads by less than `MINIMUM_LEAD`: (T,) bool."""
        undecided = np.zeros(len(tracked), bool)
        for number in np.unique(found.target[~tracked[found.target]]):
            rank, xyz = found.rank[found.target == number], found.xyz[found.target == number]
            rival = ~near(xyz, xyz[rank.argmax()], self.params.reach)
            undecided[number] = rank.max() < rank[rival].max(initial=-np.inf) + MINIMUM_LEAD
        return undecided

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
        """Log-odds of an interrupted track decay, and so do those of a deleted one while nothing shows it.

        What spoke against a track goes on to do so near its last position: the same candidates say nothing
        new, so it returns in a frame in which the views rather show a ball. Elsewhere nothing speaks against
        the target. The likeliest of its rival positions holds, for the fusion to judge.
        """
        own = (found.target == number).nonzero()[0]
        best = int(own[found.rank[own].argmax()]) if len(own) else -1
        before, fading = self.existence[number], self.rules.memory ** self.steps(forecast)
        if not len(before.rivals.odds):
            return Existence.unknown()._replace(odds=fading * before.odds), best
        if forecast is None or forecast.state[number] != MISSING:
            return before._replace(odds=0.0), best
        odds = before.rivals.odds[0] * (fading if best < 0 else 1.0)
        if odds >= self.rules.deletion or (best >= 0 and found.evidence[best] > 0):
            return Existence.unknown(), best
        return Existence(odds, False, before.rivals._replace(odds=np.array([odds]))), best
