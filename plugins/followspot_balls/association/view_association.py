"""Association of candidates with targets, and existence of targets, by the likelihoods of all views."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from followspot import Array, Latest, Stage
from followspot.tracking import Candidates, ExistenceOdds, Forecast
from followspot_balls.association.existence import Existence, OddsRules, restored, with_track
from followspot_balls.association.finite_messages import finite_candidates, finite_forecast
from followspot_balls.association.hypotheses import Hypotheses, MotionPrior, hypotheses
from followspot_balls.association.likelihood import ball_log_ratio, information, log_occam_factors, precision
from followspot_balls.association.view_evidence import HypothesisViews, ViewEvidence
from followspot_balls.association.view_params import ViewParams
from followspot_balls.association.visibility import predicted, updated
from followspot_balls.pairs.camera_numbers import numbered
from followspot_balls.scene.targets import lost_targets, tracked_targets

MINIMUM_DENSITY_RATIO = 0.1
"""Smallest density of a blob as the target, over its density as anything else, if it may show the target."""
STEP = 1 / 30
"""Time of one step of existence and detection, s; a frame that comes sooner counts as a fraction of it."""


class WeighedHypotheses(NamedTuple):
    """M hypotheses with their log-likelihood ratios."""

    xyz: Array
    """(M, 3) m."""
    target: Array
    """(M,)."""
    rank: Array
    """(M,) log-likelihood ratio among the hypotheses of a target."""
    evidence: Array
    """(M,) log-likelihood ratio that changes the existence of the target."""
    fit: Array
    """(M,) log-likelihood ratio of the views that show it, without the others."""
    complete: Array
    """(M,) bool, whether three views that all make pairs with each other show it."""

    def likeliest(self, count: int) -> list[int]:
        """The likeliest hypothesis of each of `count` targets, -1 for none."""
        best = [-1] * count
        for number in np.unique(self.target).tolist() if len(self.target) else ():
            own = (self.target == number).nonzero()[0]
            best[number] = int(own[self.rank[own].argmax()])
        return best


_NONE = np.zeros(0)
NO_HYPOTHESES = WeighedHypotheses(np.zeros((0, 3)), np.zeros(0, int), _NONE, _NONE, _NONE, np.zeros(0, bool))


@dataclass(frozen=True)
class Associated:
    """The candidates that targets keep, and the existence of the targets."""

    candidates: Candidates
    existence: ExistenceOdds


class ViewAssociation(Stage, ABC):
    """Base of stages that leave each target the candidates of its likeliest position, or none.

    The hypotheses of a target are that it moves as forecast, and that it jumps to one of its candidates. Each
    hypothesis is moved to the position nearby that the blobs of all views make likeliest. A view that has the
    position in its picture and detects nothing there counts against it; it counts more if it has detected
    the target lately. Other blobs nearby, and the other targets, count as clutter. Subclasses say which
    targets keep all their candidates, what is evidence of a ball, and when a frame is left out.
    """

    class Params(ViewParams):
        """How views detect balls and clutter, and how evidence changes the existence of targets."""

    params: Params

    def setup(self) -> None:
        p = self.params
        self.cameras, cameras = tuple(self.room.cameras), list(self.room.cameras.values())
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.colored = bool(self.color.any())
        self.depth = any(c.kind == "depth" for c in cameras)
        self.evidence = ViewEvidence(self.room, p)
        self.prior = MotionPrior(p.forecast_sigma, p.jump_sigma, p.jump_probability, p.reach)
        self.rules = OddsRules(p.memory, p.drift, p.largest_odds, p.silence_odds)
        self.existence = [Existence.unknown() for _ in self.room.targets]
        self.usual = np.full((len(self.room.targets), len(cameras)), p.detection)
        """Detection probabilities of targets of which nothing is known: (T, C)."""
        self.detection = self.usual

    @abstractmethod
    def unweighed(self, candidates: Candidates, forecast: Forecast | None, tracked: Array) -> Array:
        """Which targets keep all their candidates: (T,) bool. tracked: (T,) bool."""

    @abstractmethod
    def unweighed_log_ratio(self) -> float:
        """Log-likelihood ratio of a frame for a tracked target that keeps all its candidates."""

    @abstractmethod
    def evidence_ratio(self, log_ratio: Array, occam: Array) -> Array:
        """Log-likelihood ratios that change the existence of targets: (M,).

        log_ratio: (M, C), occam: (3, M), for :func:`followspot_balls.association.likelihood.ball_log_ratio`.
        """

    def undecided(self, found: WeighedHypotheses, tracked: Array) -> Array:
        """Which targets keep all their candidates although they were weighed: (T,) bool; by default none."""
        return np.zeros(len(tracked), bool)

    def complete(self, found: Hypotheses, candidates: Candidates, lost: Array) -> Array:
        """Which hypotheses three views show that all make pairs with each other: (M,) bool; by default none.

        lost: (T,) bool.
        """
        return np.zeros(len(found.target), bool)

    @abstractmethod
    def left_out(self, found: WeighedHypotheses, best: int) -> bool:
        """Whether a tracked target gets no candidates in this frame, although it has a likeliest position."""

    @abstractmethod
    def without_track(
        self, number: int, found: WeighedHypotheses, forecast: Forecast | None, tracked: Array
    ) -> tuple[Existence, int]:
        """The existence of a target that is not tracked, and its confirmed hypothesis, -1 for none."""

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Associated:
        count = len(self.existence)
        if self.depth:
            return Associated(candidates, self.existence_odds(*np.zeros((2, count), bool)))
        if forecast is not None and not len(forecast.state):
            forecast = None
        candidates = finite_candidates(numbered(candidates, self.cameras))
        forecast = finite_forecast(forecast)
        lost, tracked = lost_targets(forecast, count), tracked_targets(forecast, count)
        unweighed = self.unweighed(candidates, forecast, tracked)
        if np.count_nonzero(unweighed) == unweighed.size:
            return self.without_hypotheses(candidates, forecast, tracked, unweighed)
        sure = candidates.targets & candidates.confirmed[:, None]
        rows = np.where(lost | sure.any(axis=0), sure, candidates.targets)
        row, target = np.nonzero(rows & ~unweighed)
        if not len(row):
            left = self.kept(candidates, candidates.targets & unweighed)
            return self.without_hypotheses(left, forecast, tracked, unweighed)
        blobs = self.evidence.blobs(candidates, forecast, tracked)
        initial = hypotheses(candidates.xyz, row, target, forecast, tracked, self.prior)
        found, views = self.evidence.likeliest(initial, blobs, self.detection)
        weighed = self.weighed(found, views, candidates, lost)
        self.detection = self.next_detection(weighed, views, forecast, tracked)
        unweighed = unweighed | self.undecided(weighed, tracked)
        chosen = self.decide(weighed, forecast, tracked, unweighed)
        target, row = found.target[chosen], found.row[chosen]
        used = np.where(views.blobs.ratio[chosen] > MINIMUM_DENSITY_RATIO, views.blobs.slot[chosen], -1)
        keep = np.tile(unweighed, (len(candidates.xyz), 1))
        keep[:, target] = (used[:, candidates.view] == blobs.table.slot).all(axis=2).T
        initiated = ~tracked[target]
        keep[row[initiated], target[initiated]] = True
        left = self.kept(candidates, candidates.targets & keep)
        return Associated(left, self.existence_odds(tracked, unweighed))

    def without_hypotheses(
        self, left: Candidates, forecast: Forecast | None, tracked: Array, unweighed: Array
    ) -> Associated:
        """The outputs of a frame in which nothing is weighed. left: the candidates that targets keep."""
        self.decide(NO_HYPOTHESES, forecast, tracked, unweighed)
        self.detection = self.usual
        return Associated(left, self.existence_odds(tracked, unweighed))

    def existence_odds(self, tracked: Array, unweighed: Array) -> ExistenceOdds:
        """The existence of targets after the frame.

        tracked: (T,) bool; unweighed: (T,) bool, which keep all their candidates.
        """
        odds = np.array([one.odds for one in self.existence])
        given_up = tracked & ~unweighed & (odds < self.rules.deletion)
        return ExistenceOdds(odds=np.where(tracked, odds, np.nan), given_up=given_up)

    def weighed(
        self, found: Hypotheses, views: HypothesisViews, candidates: Candidates, lost: Array
    ) -> WeighedHypotheses:
        """The hypotheses with their log-likelihood ratios."""
        known = information(views.jacobian, precision(views.blobs, views.log_ratio))
        occam = log_occam_factors(known, self.color, 1 / found.variance)
        rank = ball_log_ratio(views.log_ratio, self.color, occam, self.params.other_probability)
        evidence = self.evidence_ratio(views.log_ratio, occam)
        fit = np.maximum(views.log_ratio, 0.0).sum(axis=1) + occam[0]
        complete = self.complete(found, candidates, lost)
        return WeighedHypotheses(
            found.xyz, found.target, rank - found.improbability(), evidence, fit, complete
        )

    def next_detection(
        self, found: WeighedHypotheses, views: HypothesisViews, forecast: Forecast | None, tracked: Array
    ) -> Array:
        """Probabilities that the views detect the targets in the next frame: (T, C)."""
        detection = self.usual.copy()
        persistence = self.params.persistence ** self.steps(forecast)
        for number, best in enumerate(found.likeliest(len(detection))):
            if best >= 0 and tracked[number]:
                known = updated(self.detection[number], views.blobs.ratio[best], views.in_picture[best])
                detection[number] = predicted(known, self.params.detection, persistence)
        return detection

    def steps(self, forecast: Forecast | None) -> float:
        """Number of steps that a frame counts as, at most 1."""
        return 1.0 if forecast is None else min(forecast.period / STEP, 1.0)

    def decide(
        self, found: WeighedHypotheses, forecast: Forecast | None, tracked: Array, unweighed: Array
    ) -> Array:
        """The accepted hypotheses, at most one for each target: (D,) numbers of some of the M."""
        chosen: list[int] = []
        steps, likeliest = self.steps(forecast), found.likeliest(len(self.existence))
        for number, (before, best) in enumerate(zip(self.existence, likeliest, strict=True)):
            if tracked[number] and forecast is not None:
                log_ratio = found.evidence[best] if best >= 0 else 0.0
                log_ratio = self.unweighed_log_ratio() if unweighed[number] else log_ratio
                self.existence[number] = with_track(
                    before, log_ratio, forecast.xyz[number], self.rules, steps
                )
                if best >= 0 and self.left_out(found, best):
                    best = -1
            else:
                self.existence[number], best = self.without_track(number, found, forecast, tracked)
            accepted = best >= 0 and not unweighed[number]
            if accepted and self.existence[number].odds >= self.rules.deletion:
                chosen.append(best)
        return np.array(chosen, int)

    def kept(self, candidates: Candidates, targets: Array) -> Candidates:
        """The candidates, with the targets that keep them, (N, T) bool; those of no target are left out."""
        if np.array_equal(targets, candidates.targets):
            return candidates
        return replace(candidates, targets=targets).where(np.flatnonzero(targets.any(axis=1)))

    def state(self) -> Any:
        existence = [{**one._asdict(), "rivals": one.rivals._asdict()} for one in self.existence]
        return {"existence": existence, "detection": self.detection}

    def restore(self, state: Any) -> None:
        self.existence = [restored(one) for one in state["existence"]]
        self.detection = np.array(state["detection"], float)
