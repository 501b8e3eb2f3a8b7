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
"""Log-likelihood ratio of such a frame, nats. It is small, because one colour blob on the ray to a reflector
makes as many candidates."""
GATE = 3.0
"""Distance from the forecast up to which a candidate is at it, sigmas."""
MINIMUM_GATE = 0.03
"""The same in m, where the forecast is more exact than a pair of blobs."""
MINIMUM_LEAD = 1.0
"""Smallest lead of the likeliest rival position over the next one, nats. If the lead is smaller, all
candidates stay, and the fusion states a large covariance."""


class AssociateTracked(ViewAssociation):
    """Leave tracked targets the candidates of their likeliest positions if few are at their forecasts.

    Few means fewer than three. The likelihood of a position is that of `balls.associate`: it includes views
    that detect nothing there. No single frame ends a track. The log-odds of existence change by the
    likelihood ratio of a ball against a reflector, which colour cameras do not show; below `silence_odds` the
    track ends. Near its last position, the target then returns in a frame that speaks for a ball, or when
    nothing has been found there for some frames.

    If evident pairs show a target without a track at several positions, it keeps only the candidates of the
    likeliest position, provided that this one leads clearly. All other targets keep all their candidates, and
    the fusion weighs them. If the room has depth cameras, all candidates stay, because the likelihoods do not
    include measured depths.
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
        """Which targets are missing because this stage ended their tracks: (T,) bool."""
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
        """A small ratio, because candidates that agree are no independent evidence."""
        return SETTLED_LOG_RATIO

    def evidence_ratio(self, log_ratio: Array, occam: Array) -> Array:
        """Against a reflector alone: if only colour cameras show something, it may be a ball on the floor."""
        return ball_vs_reflector_log_ratio(log_ratio, self.color, occam)

    def left_out(self, found: WeighedHypotheses, best: int) -> bool:
        """Never: a single frame does not speak against a track."""
        return False

    def without_track(
        self, number: int, found: WeighedHypotheses, forecast: Forecast | None, tracked: Array
    ) -> tuple[Existence, int]:
        """The log-odds of a target without a track, and its likeliest hypothesis.

        The log-odds of an interrupted track decay. Those of a deleted track decay only in frames in which no
        candidate shows the target near its last position: the candidates that spoke against the track bring
        no new evidence. Such a target returns there when its log-odds have decayed enough, or in a frame that
        speaks for a ball. Elsewhere nothing speaks against the target.
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
