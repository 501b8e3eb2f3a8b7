"""Association of all targets, and confirmation of positions of those without a track."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field
from followspot.tracking import Candidates, Forecast
from followspot_balls.association.existence import Confirmation, Existence, TargetCandidates, without_track
from followspot_balls.association.hypotheses import Hypotheses
from followspot_balls.association.likelihood import ball_log_ratio
from followspot_balls.association.recovery_evidence import appearing
from followspot_balls.association.view_association import ViewAssociation, WeighedHypotheses
from followspot_balls.scene.targets import lost_targets
from followspot_balls.triangulate import alike

CLEAR = 4
"""Number of views that show a target clearly if nothing contradicts them."""


class Associate(ViewAssociation):
    """Keep the candidates whose blobs the likeliest position of each target explains; none if it is no ball.

    A target moves as forecast, or it jumps to a candidate: each is a hypothesis, at the position nearby that
    all views make likeliest. All views count, also those that detect nothing there, by how often they
    detected the target lately; other blobs around and other targets count as clutter. Colour cameras tell
    whose ball it is and infrared cameras that it is one, so a target needs both in the long run if the room
    has both. A frame that contradicts a tracked target, by blobs that hardly fit, leaves it no candidates.

    If the room has depth cameras, all candidates stay, for the weighing of views does not know their
    measurements. `balls.associate_tracked` weighs tracked targets that few candidates show, and sought ones
    with rival positions.
    """

    advice = "lower confirmation_odds, or give the room more cameras that see each place"

    class Params(ViewAssociation.Params):
        """When positions of sought targets are confirmed, and those of tracked ones left out."""

        absence: float = Field(
            0.5,
            ge=0,
            unit="nats",
            description="further decrease of the log-odds of a sought target's position in a frame without "
            "candidates there; raising it drops positions sooner",
        )
        least_evidence: float = Field(
            -1.0,
            unit="nats",
            description="log-likelihood ratio below which a frame contradicts a tracked target; raising it "
            "prefers gaps to wrong positions",
        )
        least_fit: float = Field(
            5.0,
            unit="nats",
            description="log-likelihood ratio of the views that show the target; below it, a frame that "
            "contradicts the target leaves it no candidates; raising it prefers gaps to wrong positions",
        )
        confirmation_odds: float = Field(
            2.0,
            unit="nats",
            description="log-odds of existence from which a lost target is confirmed although rival "
            "positions are near; one that leads all others by twice `confirmation_margin`, or has no rival, "
            "needs only more than 0; raising it avoids false recoveries",
        )
        confirmation_margin: float = Field(
            3.0,
            ge=0,
            unit="nats",
            description="smallest lead of a position's log-odds over the next one's; raising it confirms "
            "targets later",
        )

    params: Params

    def setup(self) -> None:
        super().setup()
        p = self.params
        self.alike = alike(self.room) | ~self.color.any()
        np.fill_diagonal(self.alike, False)
        self.confirmation = Confirmation(p.absence, p.confirmation_odds, p.confirmation_margin, p.reach)

    def unweighed(self, candidates: Candidates, forecast: Forecast | None, tracked: Array) -> Array:
        """Which tracked targets one blob in each of four or more views shows, that all agree: (T,) bool.

        Two of them are colour and two infrared cameras where the room has both. Nothing is left to choose.
        """
        uses = (candidates.view[..., None] == np.arange(len(self.color))).sum(axis=1)
        times = candidates.targets.T.astype(float) @ uses
        seen = times > 0
        views = seen.sum(axis=1)
        each = ((times == views[:, None] - 1) | ~seen).all(axis=1)
        kinds = [kind for kind in (self.color, ~self.color) if kind.any()]
        both = np.all([seen[:, kind].sum(axis=1) >= CLEAR // len(kinds) for kind in kinds], axis=0)
        return np.asarray(tracked & each & both)

    def unweighed_log_ratio(self) -> float:
        """The largest log-odds of existence: the target is there."""
        return self.rules.maximum

    def evidence_ratio(self, log_ratio: Array, occam: Array) -> Array:
        """Against whatever else could be there: paint, light and reflectors, as likely as a ball before."""
        return ball_log_ratio(log_ratio, self.color, occam, 1.0)

    def complete(self, found: Hypotheses, candidates: Candidates, lost: Array) -> Array:
        """Those of lost targets, for a new position is confirmed sooner if three views show it."""
        complete = np.zeros(len(found.target), bool)
        if lost.any():
            rows = found.row >= 0
            complete[rows] = appearing(candidates, lost)[found.row[rows], found.target[rows]]
        return complete

    def left_out(self, found: WeighedHypotheses, best: int) -> bool:
        """Whether a frame contradicts a position, and blobs that show it fit hardly better than clutter."""
        p = self.params
        return bool(found.evidence[best] < p.least_evidence and found.fit[best] < p.least_fit)

    def without_track(
        self, number: int, found: WeighedHypotheses, forecast: Forecast | None, tracked: Array
    ) -> tuple[Existence, int]:
        """Rival positions of the target one frame later, of which one may be confirmed."""
        own = (found.target == number).nonzero()[0]
        lost = lost_targets(forecast, len(self.existence))[number]
        center = None if forecast is None or lost else forecast.xyz[number]
        others = int(np.logical_and(self.alike[number], ~tracked).sum())
        candidates = TargetCandidates(found.xyz[own], found.evidence[own], found.complete[own])
        before = self.existence[number]
        existence, best = without_track(before, candidates, center, others, self.rules, self.confirmation)
        return existence, int(own[best]) if best >= 0 else -1
