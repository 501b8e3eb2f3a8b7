"""Whether all views make it likely that a lost target turned up: a likelihood ratio for its place.

Candidates that agree are no independent evidence: one blob of a colour camera that lies by chance on the
ray to a reflector makes a candidate with each infrared camera. So the views are weighed, not their pairs,
also those that see the place and show nothing there (Bar-Shalom, Daum & Huang 2009); a blob counts for more
where its view lately showed nothing of the kind. An evident place that one frame hardly confirms is found
when several in a row do (a sequential probability ratio test).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Array, Field, Room, StageParams
from followspot.tracking import MISSING, Candidates, Forecast, Positions
from followspot_balls.association.hypotheses import Hypotheses
from followspot_balls.association.likelihood import (
    ball_ratio,
    coincidences,
    information,
    precision,
    reflector_ratio,
)
from followspot_balls.association.refusals import Refusals
from followspot_balls.association.view_evidence import PlaceViews, ViewEvidence
from followspot_balls.association.view_params import ViewParams
from followspot_balls.scene.targets import lost_targets, tracked_targets

ELSEWHERE = 1.0
"""Sigma of the place of a target that is not where it seems to be, m: some place in the room."""
AGREEING = 3
"""Candidates that confirm a target in one frame."""
BALL_LIKELY = 1.0
"""Log-likelihood ratio of a frame, nats, above which an evident place is likelier a ball than light or paint,
so that the ratios of the frames before count for it, too."""
OUTSTANDING = 3.0
"""Lead over `sure_recovery_evidence` from which a place stands out, nats: a twentieth of the odds remains."""


class RecoveryParams(StageParams):
    """What all views must say of a place where a lost target turns up."""

    least_recovery_evidence: float = Field(
        -1.0,
        unit="nats",
        description="log-likelihood ratio of all views below which the position of a lost target is "
        "rejected; raising it avoids false recoveries and delays those of partly hidden balls",
    )
    sure_recovery_evidence: float = Field(
        2.0,
        unit="nats",
        description="log-likelihood ratio of all views from which a lost target is found in one frame; below "
        "it, several frames must agree; raising it avoids false recoveries and delays true ones",
    )


class Recovery:
    """The views of a room, which weigh the places of lost targets.

    How balls and clutter show is told by the defaults of :class:`ViewParams`, whatever the parameters of the
    association in the same graph are.
    """

    def __init__(self, room: Room, params: RecoveryParams) -> None:
        self.params = params
        p = ViewParams()
        cameras = list(room.cameras.values())
        self.reach = p.reach
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.depth = any(c.kind == "depth" for c in cameras)
        self.shown = np.full((len(room.targets), len(cameras)), p.detection)
        self.odds = np.zeros(len(room.targets))
        """(T,) nats, what frames in a row said for an evident place of each lost target."""
        self.place = np.zeros((len(room.targets), 3))
        """(T, 3) m, that place."""
        self.refusals = Refusals(tuple(room.targets))
        self.evidence = ViewEvidence(room, p, remembering=True)

    def judged(self, positions: Positions, candidates: Candidates, forecast: Forecast | None) -> Positions:
        """The positions without those of lost targets that the views contradict.

        An evident one that they make sure counts as three candidates that agree. If they hardly confirm
        candidates that agree, one counts, and the position is as vague as the place is unlikely: it needs
        several frames. If the room has depth cameras, all positions remain, for the weighing of views does
        not know their measurements.
        """
        count = len(self.shown)
        lost = lost_targets(forecast, count)[positions.target]
        weighed = lost & positions.confirmed & (positions.evident | (positions.support > 1))
        if self.depth or not weighed.any():
            self.forget(forecast)
            return positions
        row = weighed.nonzero()[0]
        ratio, reflector = np.full((2, len(weighed)), np.inf)
        found = positions.xyz[row], positions.target[row]
        ratio[row], reflector[row] = self.ratios(*found, candidates, forecast)
        total = self.added_up(positions, reflector, forecast)
        ball_likely = positions.evident & (ratio > BALL_LIKELY)
        likely = ratio >= self.params.least_recovery_evidence
        positions = self.believed(
            positions, weighed, ratio, np.where(ball_likely, np.maximum(ratio, total), ratio)
        )
        if likely.all():
            return positions
        self.refusals.frames[positions.target[~likely]] += 1
        return positions.where(likely)

    def added_up(self, positions: Positions, ratio: Array, forecast: Forecast | None) -> Array:
        """The ratios against reflectors, with those of the frames in a row before: (M,).

        Those of a target add up while it has an evident position within one step of its last one. Only
        evident positions add up: paint and reflectors that stay say the same again. The sum counts as
        evidence of a ball only if `BALL_LIKELY` holds in the frame itself.
        ratio: (M,) of :meth:`ratios`, against reflectors; infinite if not weighed.
        """
        row = (positions.evident & np.isfinite(ratio)).nonzero()[0]
        target, xyz = positions.target[row], positions.xyz[row]
        off = xyz - self.place[target]
        total = ratio.copy()
        total[row] += np.where(np.vecdot(off, off) < self.reach**2, self.odds[target], 0.0)
        self.forget(forecast)
        self.odds[target], self.place[target] = total[row], xyz
        return total

    def forget(self, forecast: Forecast | None) -> None:
        """Forget what was said of targets other than missing ones, which are sought nearby in this frame."""
        if forecast is None or len(forecast.state) != len(self.odds):
            self.odds = np.zeros(len(self.odds))
        else:
            self.odds = np.where(forecast.state == MISSING, self.odds, 0.0)

    def believed(self, positions: Positions, weighed: Array, ratio: Array, total: Array) -> Positions:
        """The positions, of which the weighed ones are found in one frame if they are sure, else in several.

        weighed: (M,) bool; ratio, total: (M,) log-likelihood ratios of this frame, and with those before;
        infinite if not weighed.
        """
        sure = weighed & positions.evident & (ratio >= self.params.sure_recovery_evidence)
        support = np.where(sure, np.maximum(positions.support, AGREEING), positions.support)
        doubted = (total < self.params.sure_recovery_evidence) & (positions.support > 1)
        support = np.where(doubted, 1, support).astype(np.int32)
        if not doubted.any():
            return replace(positions, support=support)
        vague = doubted * ELSEWHERE**2 / (1 + np.exp(total))
        covariance = positions.covariance + vague[:, None, None] * np.eye(3)
        return replace(positions, support=support, covariance=covariance)

    def ratios(self, xyz: Array, target: Array, candidates: Candidates, forecast: Forecast | None) -> Array:
        """Log-likelihood ratios of balls at M places against whatever else, and against reflectors: (2, M).

        Those that do not stand out are taken at the likeliest places nearby.
        xyz: (M, 3) m; target: (M,).
        """
        tracked = tracked_targets(forecast, len(self.shown))
        blobs = self.evidence.blobs(candidates, forecast, tracked)
        count = len(xyz)
        begun = Hypotheses(
            xyz, target, np.full(count, -1), xyz, np.full(count, self.reach**2), np.zeros(count)
        )
        views = self.evidence.views(begun, blobs, self.shown)
        ratio = self.weighed(begun, views)
        close = (ratio[0] < self.params.sure_recovery_evidence + OUTSTANDING).nonzero()[0]
        if len(close):
            near = Hypotheses(*(column[close] for column in begun))
            seen = views.where(close)
            ratio[:, close] = self.weighed(*self.evidence.refined(near, seen, blobs, self.shown))
        return ratio

    def weighed(self, found: Hypotheses, views: PlaceViews) -> Array:
        """The log-likelihood ratios of hypotheses from their views, as of :meth:`ratios`: (2, M)."""
        known = information(views.jacobian, precision(views.likely, views.ratio))
        chance = coincidences(known, self.color, 1 / found.variance)
        return np.array(
            [
                ball_ratio(views.ratio, self.color, chance, 1.0),
                reflector_ratio(views.ratio, self.color, chance),
            ]
        )
