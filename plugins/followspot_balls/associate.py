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
    """Leave each target the candidates that its likeliest position explains; none if no ball is there.

    The hypotheses of a target are that it moves as forecast, and that it jumps to one of its candidates. Each
    hypothesis is moved to the position nearby that the blobs of all views make likeliest. A view that has the
    position in its picture and detects nothing there counts against it; it counts more if it has detected
    the target lately. Other blobs nearby, and the other targets, count as clutter.

    Colour cameras tell which ball it is, infrared cameras that it is a ball. If the room has both kinds, a
    target needs evidence of both in the long run. If a frame contradicts a tracked target, and the blobs that
    show it hardly fit, the target gets no candidates in that frame.

    If the room has depth cameras, all candidates stay, because the likelihoods do not include measured
    depths. `balls.associate_tracked` decides only about tracked targets that few candidates show, and about
    targets without a track that candidates show at several positions.
    """

    advice = "lower confirmation_odds, or give the room more cameras that see each place"

    class Params(ViewAssociation.Params):
        """When the stage confirms a target without a track, and when it leaves out a tracked one."""

        absence: float = Field(
            0.5,
            ge=0,
            unit="nats",
            description="additional decrease of the log-odds of a possible position of a target without a "
            "track, in a frame without candidates there; raising it drops positions sooner",
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
            description="log-odds that confirm the position of a target without a track; log-odds above 0 "
            "are enough if they lead those of all rival positions by twice `confirmation_margin`, or if "
            "there are no rivals; raising it avoids false recoveries",
        )
        confirmation_margin: float = Field(
            3.0,
            ge=0,
            unit="nats",
            description="smallest lead, in log-odds, of a confirmed position over the next likely one; "
            "raising it confirms targets later",
        )

    params: Params

    def setup(self) -> None:
        super().setup()
        p = self.params
        self.alike = alike(self.room) | ~self.color.any()
        np.fill_diagonal(self.alike, False)
        self.confirmation = Confirmation(p.absence, p.confirmation_odds, p.confirmation_margin, p.reach)

    def unweighed(self, candidates: Candidates, forecast: Forecast | None, tracked: Array) -> Array:
        """Which tracked targets four or more views show by one blob each, and all views agree: (T,) bool.

        If the room has both kinds, at least two of the views are of colour and two of infrared cameras. Such
        a target leaves no choice between candidates.
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
        """Of lost targets alone: their positions are confirmed sooner if three views show them."""
        complete = np.zeros(len(found.target), bool)
        if lost.any():
            rows = found.row >= 0
            complete[rows] = appearing(candidates, lost)[found.row[rows], found.target[rows]]
        return complete

    def left_out(self, found: WeighedHypotheses, best: int) -> bool:
        """Whether the frame contradicts the position, and its blobs hardly fit better than clutter."""
        p = self.params
        return bool(found.evidence[best] < p.least_evidence and found.fit[best] < p.least_fit)

    def without_track(
        self, number: int, found: WeighedHypotheses, forecast: Forecast | None, tracked: Array
    ) -> tuple[Existence, int]:
        """The rival positions of the target one frame later, and the confirmed one, if any."""
        own = (found.target == number).nonzero()[0]
        lost = lost_targets(forecast, len(self.existence))[number]
        center = None if forecast is None or lost else forecast.xyz[number]
        others = int(np.logical_and(self.alike[number], ~tracked).sum())
        candidates = TargetCandidates(found.xyz[own], found.evidence[own], found.complete[own])
        before = self.existence[number]
        existence, best = without_track(before, candidates, center, others, self.rules, self.confirmation)
        return existence, int(own[best]) if best >= 0 else -1
