"""Association of candidates with targets, and the existence of each target, weighed over all views."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from followspot import Array, Latest, Stage
from followspot.tracking import Candidates, ExistenceOdds, Forecast
from followspot_balls.association.existence import Existence, Rules, followed, restored
from followspot_balls.association.finite_messages import finite_candidates, finite_forecast
from followspot_balls.association.hypotheses import Hypotheses, MotionPrior, hypotheses
from followspot_balls.association.likelihood import ball_ratio, coincidences, information, precision
from followspot_balls.association.recovery_evidence import appearing
from followspot_balls.association.view_evidence import PlaceViews, ViewEvidence
from followspot_balls.association.view_params import ViewParams
from followspot_balls.association.visibility import predicted, updated
from followspot_balls.pairs.camera_numbers import numbered
from followspot_balls.scene.targets import lost_targets, tracked_targets

SHOWN = 0.1
"""Ratio of a blob's densities from which it may show the target."""
STEP = 1 / 30
"""Time that counts as one step of existence and visibility, s; frames may follow each other faster."""


class Weighed(NamedTuple):
    """M hypotheses as the views weigh them."""

    xyz: Array
    """(M, 3) m."""
    target: Array
    """(M,)."""
    rank: Array
    """(M,) log-likelihood ratio, as a rival of the other hypotheses."""
    evidence: Array
    """(M,) likewise, as evidence of a ball."""
    fit: Array
    """(M,) likewise, of the views alone that show it."""
    complete: Array
    """(M,) bool, whether three views that all make pairs with each other show it."""

    def likeliest(self, count: int) -> list[int]:
        """The likeliest hypothesis of each of `count` targets, -1 for none."""
        best = [-1] * count
        for number in np.unique(self.target).tolist() if len(self.target) else ():
            mine = (self.target == number).nonzero()[0]
            best[number] = int(mine[self.rank[mine].argmax()])
        return best


_NONE = np.zeros(0)
NOTHING = Weighed(np.zeros((0, 3)), np.zeros(0, int), _NONE, _NONE, _NONE, np.zeros(0, bool))
"""No hypothesis."""


@dataclass(frozen=True)
class Associated:
    """The candidates that are left to their targets, and what is known of the targets' existence."""

    candidates: Candidates
    existence: ExistenceOdds


class ViewAssociation(Stage, ABC):
    """Base of stages that leave targets the candidates of their likeliest places, or none.

    A target moves as forecast, or it jumps to a candidate: each is a hypothesis, at the place nearby that all
    views make likeliest. All views vote on it, also those that show nothing there, by how often they showed
    the target lately; other blobs around and other targets count as clutter. Subclasses say which targets
    keep all their candidates, what is evidence of a ball, and when a place is left out.
    """

    class Params(ViewParams):
        """How balls and clutter show, and how evidence moves the existence of targets."""

    params: Params

    def setup(self) -> None:
        p = self.params
        self.cameras, cameras = tuple(self.room.cameras), list(self.room.cameras.values())
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.colored = bool(self.color.any())
        self.depth = any(c.kind == "depth" for c in cameras)
        self.evidence = ViewEvidence(self.room, p)
        self.prior = MotionPrior(p.forecast_sigma, p.jump_sigma, p.jump_probability, p.reach)
        self.rules = Rules(p.memory, p.drift, p.largest_odds, p.silence_odds)
        self.existence = [Existence.unknown() for _ in self.room.targets]
        self.usual = np.full((len(self.room.targets), len(cameras)), p.detection)
        """Probabilities that the views show targets of which nothing is known: (T, C)."""
        self.shown = self.usual

    @abstractmethod
    def unweighed(self, candidates: Candidates, forecast: Forecast | None, tracked: Array) -> Array:
        """Which targets keep all their candidates: (T,) bool. tracked: (T,) bool."""

    @abstractmethod
    def unweighed_gain(self) -> float:
        """Log-likelihood ratio of a frame for a tracked target that keeps all its candidates."""

    @abstractmethod
    def evidence_ratio(self, views: Array, chance: Array) -> Array:
        """Log-likelihood ratios that move the existence of targets: (M,).

        views: (M, C), chance: (3, M), as for :func:`followspot_balls.association.likelihood.ball_ratio`.
        """

    @abstractmethod
    def left_out(self, found: Weighed, best: int) -> bool:
        """Whether a tracked target gets no candidates in this frame, though a place is its likeliest."""

    @abstractmethod
    def sought(
        self, number: int, found: Weighed, forecast: Forecast | None, tracked: Array
    ) -> tuple[Existence, int]:
        """The existence of a target that is not tracked, and the hypothesis that holds, -1 for none."""

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Associated:
        count = len(self.existence)
        if self.depth:
            return Associated(candidates, self.existence_odds(*np.zeros((2, count), bool)))
        if forecast is not None and not len(forecast.state):
            forecast = None
        candidates = finite_candidates(numbered(candidates, self.cameras))
        forecast = finite_forecast(forecast)
        lost, tracked = lost_targets(forecast, count), tracked_targets(forecast, count)
        clear = self.unweighed(candidates, forecast, tracked)
        if clear.all():
            return self.without_hypotheses(candidates, forecast, tracked, clear)
        sure = candidates.targets & candidates.confirmed[:, None]
        rows = np.where(lost | sure.any(axis=0), sure, candidates.targets)
        row, target = np.nonzero(rows & ~clear)
        if not len(row):
            left = self.kept(candidates, candidates.targets & clear)
            return self.without_hypotheses(left, forecast, tracked, clear)
        blobs = self.evidence.blobs(candidates, forecast, tracked)
        begun = hypotheses(candidates.xyz, row, target, forecast, tracked, self.prior)
        found, views = self.evidence.likeliest(begun, blobs, self.shown)
        weighed = self.weighed(found, views, candidates, lost)
        self.shown = self.remembered(weighed, views, forecast, tracked)
        chosen = self.decide(weighed, forecast, tracked, clear)
        mine, begin = found.target[chosen], found.row[chosen]
        used = np.where(views.likely.ratio[chosen] > SHOWN, views.likely.slot[chosen], -1)
        keep = np.tile(clear, (len(candidates.xyz), 1))
        keep[:, mine] = (used[:, candidates.view] == blobs.table.slot).all(axis=2).T
        first = ~tracked[mine]
        keep[begin[first], mine[first]] = True
        left = self.kept(candidates, candidates.targets & keep)
        return Associated(left, self.existence_odds(tracked, clear))

    def without_hypotheses(
        self, left: Candidates, forecast: Forecast | None, tracked: Array, clear: Array
    ) -> Associated:
        """The outputs of a frame in which nothing is weighed. left: what remains of the candidates."""
        self.decide(NOTHING, forecast, tracked, clear)
        self.shown = self.usual
        return Associated(left, self.existence_odds(tracked, clear))

    def existence_odds(self, tracked: Array, clear: Array) -> ExistenceOdds:
        """What is known of targets after the frame. tracked, clear: (T,) bool, which keep all candidates."""
        odds = np.array([one.odds for one in self.existence])
        given_up = tracked & ~clear & (odds < self.rules.silent)
        return ExistenceOdds(odds=np.where(tracked, odds, np.nan), given_up=given_up)

    def weighed(self, found: Hypotheses, views: PlaceViews, candidates: Candidates, lost: Array) -> Weighed:
        """The hypotheses with what speaks for them."""
        known = information(views.jacobian, precision(views.likely, views.ratio))
        chance = coincidences(known, self.color, 1 / found.variance)
        rank = ball_ratio(views.ratio, self.color, chance, self.params.other_probability)
        evidence = self.evidence_ratio(views.ratio, chance)
        fit = np.maximum(views.ratio, 0.0).sum(axis=1) + chance[0]
        complete = np.zeros(len(found.target), bool)
        if lost.any():
            begun = found.row >= 0
            complete[begun] = appearing(candidates, lost)[found.row[begun], found.target[begun]]
        return Weighed(found.xyz, found.target, rank - found.improbability(), evidence, fit, complete)

    def remembered(
        self, found: Weighed, views: PlaceViews, forecast: Forecast | None, tracked: Array
    ) -> Array:
        """Probabilities that the views show the targets in the next frame: (T, C)."""
        shown = self.usual.copy()
        persistence = self.params.persistence ** self.steps(forecast)
        for number, best in enumerate(found.likeliest(len(shown))):
            if best >= 0 and tracked[number]:
                known = updated(self.shown[number], views.likely.ratio[best], views.inside[best])
                shown[number] = predicted(known, self.params.detection, persistence)
        return shown

    def steps(self, forecast: Forecast | None) -> float:
        """Steps that a frame counts as, at most 1."""
        return 1.0 if forecast is None else min(forecast.period / STEP, 1.0)

    def decide(self, found: Weighed, forecast: Forecast | None, tracked: Array, clear: Array) -> Array:
        """The hypotheses that hold, at most one for each target: (D,) numbers of some of the M."""
        chosen: list[int] = []
        steps, likeliest = self.steps(forecast), found.likeliest(len(self.existence))
        for number, (before, best) in enumerate(zip(self.existence, likeliest, strict=True)):
            if tracked[number] and forecast is not None:
                gain = found.evidence[best] if best >= 0 else 0.0
                gain = self.unweighed_gain() if clear[number] else gain
                self.existence[number] = followed(before, gain, forecast.xyz[number], self.rules, steps)
                if best >= 0 and self.left_out(found, best):
                    best = -1
            else:
                self.existence[number], best = self.sought(number, found, forecast, tracked)
            if best >= 0 and self.existence[number].odds >= self.rules.silent:
                chosen.append(best)
        return np.array(chosen, int)

    def kept(self, candidates: Candidates, targets: Array) -> Candidates:
        """The candidates that are left to targets, (N, T) bool."""
        if np.array_equal(targets, candidates.targets):
            return candidates
        return replace(candidates, targets=targets).where(np.flatnonzero(targets.any(axis=1)))

    def state(self) -> Any:
        existence = [{**one._asdict(), "places": one.places._asdict()} for one in self.existence]
        return {"existence": existence, "shown": self.shown}

    def restore(self, state: Any) -> None:
        self.existence = [restored(one) for one in state["existence"]]
        self.shown = np.array(state["shown"], float)
