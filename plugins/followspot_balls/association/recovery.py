"""Recovery of lost targets by the likelihood ratio of all views for a ball at the position that was found.

Candidates that agree are no independent evidence: one blob of a colour camera that lies by chance on the
ray to a reflector makes a candidate with each infrared camera. So the ratio is over views, not over pairs,
and includes views that have the position in their pictures and detect nothing there (Bar-Shalom, Daum &
Huang 2009). A blob counts for more if its view has shown no blobs there lately. If one frame hardly confirms
an evident position, several frames in a row can (a sequential probability ratio test). The evidence of
earlier frames decays as that of tracks does, because a patch and a reflector that stay are no new evidence.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Array, Field, Room, StageParams
from followspot.tracking import MISSING, Candidates, Forecast, Positions
from followspot_balls.association.hypotheses import Hypotheses
from followspot_balls.association.likelihood import (
    ball_log_ratio,
    ball_vs_reflector_log_ratio,
    information,
    log_occam_factors,
    precision,
)
from followspot_balls.association.refusals import Refusals
from followspot_balls.association.view_evidence import HypothesisViews, ViewEvidence
from followspot_balls.association.view_params import ViewParams
from followspot_balls.scene.targets import lost_targets, tracked_targets

ROOM_SIGMA = 1.0
"""Sigma of the position of a target if the position that was found is wrong, m: anywhere in the room."""
AGREEING = 3
"""Number of candidates that confirm a target in one frame."""
BALL_LIKELY = 1.0
"""Log-likelihood ratio of a frame, nats, above which a ball is likelier at an evident position than light or
paint; then the ratios of earlier frames count, too."""
CLEAR_LEAD = 3.0
"""Lead over `sure_recovery_evidence`, nats, that makes refinement of a position unnecessary: odds of twenty
to one."""


class RecoveryParams(StageParams):
    """How much evidence of all views the position of a lost target needs."""

    least_recovery_evidence: float = Field(
        -1.0,
        unit="nats",
        description="smallest log-likelihood ratio of all views with which the position of a lost target is "
        "accepted at all; raising it avoids false recoveries and delays those of partly hidden balls",
    )
    sure_recovery_evidence: float = Field(
        2.0,
        unit="nats",
        description="smallest log-likelihood ratio of all views with which one frame recovers a lost target; "
        "if it is smaller, several frames must agree; raising it avoids false recoveries and delays true "
        "ones",
    )


class Recovery:
    """Accepts, doubts or rejects positions of lost targets by the views of a room.

    The likelihoods have the default parameters of :class:`ViewParams`, also if the association in the same
    graph has others.
    """

    def __init__(self, room: Room, params: RecoveryParams) -> None:
        self.params = params
        p = ViewParams()
        cameras = list(room.cameras.values())
        self.reach, self.memory = p.reach, p.memory
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.depth = any(c.kind == "depth" for c in cameras)
        self.detection = np.full((len(room.targets), len(cameras)), p.detection)
        self.odds = np.zeros(len(room.targets))
        """(T,) log-odds of an evident position of each lost target after several frames, nats."""
        self.xyz = np.zeros((len(room.targets), 3))
        """(T, 3) m, that position."""
        self.refusals = Refusals(tuple(room.targets))
        self.evidence = ViewEvidence(room, p, remembering=True)

    def accepted(self, positions: Positions, candidates: Candidates, forecast: Forecast | None) -> Positions:
        """The positions, without those of lost targets that the views contradict.

        If the views make an evident position sure, its support rises to three candidates. If they hardly
        confirm a position, its support falls to one candidate, and its covariance grows with the odds against
        it, so that several frames must confirm it. If the room has depth cameras, all positions remain,
        because the likelihoods do not include measured depths.
        """
        count = len(self.detection)
        weighed = lost_targets(forecast, count).take(positions.target)
        if np.count_nonzero(weighed):
            weighed &= positions.confirmed & (positions.evident | (positions.support > 1))
        if self.depth or not np.count_nonzero(weighed):
            self.forget(forecast)
            return positions
        row = weighed.nonzero()[0]
        ratio, reflector = np.full((2, len(weighed)), np.inf)
        found = positions.xyz[row], positions.target[row]
        ratio[row], reflector[row] = self.ratios(*found, candidates, forecast)
        total = self.accumulated(positions, reflector, forecast)
        ball_likely = positions.evident & (ratio > BALL_LIKELY)
        likely = ratio >= self.params.least_recovery_evidence
        positions = self.with_support(
            positions, weighed, ratio, np.where(ball_likely, np.maximum(ratio, total), ratio)
        )
        if likely.all():
            return positions
        self.refusals.frames[positions.target[~likely]] += 1
        return positions.where(likely)

    def accumulated(self, positions: Positions, ratio: Array, forecast: Forecast | None) -> Array:
        """The log-likelihood ratios against reflectors, added to those of the preceding frames: (M,).

        The ratios of a target add up while each frame has an evident position within one step of the one
        before. Other positions do not add up: paint and reflectors that stay give the same ratio again. The
        sum counts as evidence of a ball only if the ratio of the frame itself exceeds `BALL_LIKELY`.
        ratio: (M,) of :meth:`ratios`, against reflectors; infinite if not weighed.
        """
        row = (positions.evident & np.isfinite(ratio)).nonzero()[0]
        target, xyz = positions.target[row], positions.xyz[row]
        off = xyz - self.xyz[target]
        total = ratio.copy()
        total[row] += np.where(np.vecdot(off, off) < self.reach**2, self.memory * self.odds[target], 0.0)
        self.forget(forecast)
        self.odds[target], self.xyz[target] = total[row], xyz
        return total

    def forget(self, forecast: Forecast | None) -> None:
        """Reset the log-odds of all targets except missing ones, which this frame searches nearby only."""
        if forecast is None or len(forecast.state) != len(self.odds):
            self.odds = np.zeros(len(self.odds))
        else:
            self.odds = self.odds * (forecast.state == MISSING)

    def with_support(self, positions: Positions, weighed: Array, ratio: Array, total: Array) -> Positions:
        """The positions with new support: enough to recover a target in one frame if sure, else in several.

        weighed: (M,) bool; ratio, total: (M,) log-likelihood ratios of this frame, and with those of earlier
        frames; infinite if not weighed.
        """
        sure = weighed & positions.evident & (ratio >= self.params.sure_recovery_evidence)
        support = np.where(sure, np.maximum(positions.support, AGREEING), positions.support)
        doubted = (total < self.params.sure_recovery_evidence) & (positions.support > 1)
        support = np.where(doubted, 1, support).astype(np.int32)
        if not doubted.any():
            return replace(positions, support=support)
        vague = doubted * ROOM_SIGMA**2 / (1 + np.exp(total))
        covariance = positions.covariance + vague[:, None, None] * np.eye(3)
        return replace(positions, support=support, covariance=covariance)

    def ratios(self, xyz: Array, target: Array, candidates: Candidates, forecast: Forecast | None) -> Array:
        """Log-likelihood ratios of balls at M positions, against all else and against reflectors: (2, M).

        Positions without a clear lead are moved to the likeliest positions nearby.
        xyz: (M, 3) m; target: (M,).
        """
        tracked = tracked_targets(forecast, len(self.detection))
        blobs = self.evidence.blobs(candidates, forecast, tracked)
        count = len(xyz)
        initial = Hypotheses(
            xyz, target, np.full(count, -1), xyz, np.full(count, self.reach**2), np.zeros(count)
        )
        views = self.evidence.views(initial, blobs, self.detection)
        ratio = self.weighed(initial, views)
        close = (ratio[0] < self.params.sure_recovery_evidence + CLEAR_LEAD).nonzero()[0]
        if len(close):
            doubtful = Hypotheses(*(column[close] for column in initial))
            seen = views.where(close)
            ratio[:, close] = self.weighed(*self.evidence.refined(doubtful, seen, blobs, self.detection))
        return ratio

    def weighed(self, found: Hypotheses, views: HypothesisViews) -> Array:
        """Log-likelihood ratios of hypotheses from their views, as in :meth:`ratios`: (2, M)."""
        known = information(views.jacobian, precision(views.blobs, views.log_ratio))
        occam = log_occam_factors(known, self.color, 1 / found.variance)
        return np.array(
            [
                ball_log_ratio(views.log_ratio, self.color, occam, 1.0),
                ball_vs_reflector_log_ratio(views.log_ratio, self.color, occam),
            ]
        )
