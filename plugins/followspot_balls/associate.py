"""Association of candidates with targets, and the existence of each target, weighed over all views."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from followspot import Array, Latest, Stage
from followspot.tracking import Candidates, Forecast
from followspot_balls.associate_params import AssociateParams
from followspot_balls.evidence import appearing
from followspot_balls.existence import Existence, Rules, Seen, followed, restored, sought
from followspot_balls.finite import finite_candidates, finite_forecast
from followspot_balls.hypotheses import Hypotheses, MotionPrior, hypotheses
from followspot_balls.likelihood import (
    Model,
    ball_ratio,
    coincidences,
    information,
    precision,
    reflector_ratio,
)
from followspot_balls.search import lost_targets, tracked_targets
from followspot_balls.triangulate import alike
from followspot_balls.view_evidence import ViewEvidence, Views
from followspot_balls.visibility import predicted, updated

CLEAR = 4
"""Number of views that show a target clearly if nothing contradicts them."""
SHOWN = 0.1
"""Ratio of a blob's densities from which it may show the target."""
SETTLED = 3
"""Candidates at its forecast that settle where a target is."""
SETTLED_GAIN = 1.0
"""Evidence of such a frame, nats: one colour blob on the ray to a reflector makes as many candidates."""
GATE = 3.0
"""Distance from the forecast up to which a candidate is there, sigmas."""
NEAR = 0.03
"""The same if the forecast is more exact than a pair of blobs, m."""
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

    @classmethod
    def none(cls) -> Weighed:
        """No hypothesis."""
        none = np.zeros(0)
        return cls(np.zeros((0, 3)), np.zeros(0, int), none, none, none, np.zeros(0, bool))


class Associate(Stage):
    """Keep the candidates whose blobs the likeliest place of each target explains; none if it is no ball.

    A target moves as forecast, or it jumps to a candidate: each is a hypothesis, at the place nearby that all
    views make likeliest. All views vote on it, also those that show nothing there, by how often they showed
    the target lately; other blobs around and other targets count as clutter. Colour cameras tell whose ball
    it is and infrared cameras that it is one, so a target needs both in the long run if the room has both.
    A frame that speaks against a tracked target, by blobs that hardly fit, leaves it no candidates.

    If only poor targets are weighed, the fusion weighs those that are sought, and a poor frame alone ends no
    track: its log-odds against a reflector do, for colour tells whose ball it is. If the
    room has depth cameras, all candidates stay, for the weighing of views does not know their measurements.
    """

    advice = "lower confirmation_odds, or give the room more cameras that see each place"

    class Params(AssociateParams):
        """How balls and clutter show, and how evidence moves the existence of targets."""

    params: Params

    def setup(self) -> None:
        p = self.params
        cameras = list(self.room.cameras.values())
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.poor = p.weighed == "poor"
        self.depth = any(c.kind == "depth" for c in cameras)
        self.alike = alike(self.room) | ~self.color.any()
        np.fill_diagonal(self.alike, False)
        model = Model(p.detection, p.clutter, p.neighbourhood, p.blob_sigma, p.relative_sigma, p.hidden_sigma)
        self.evidence = ViewEvidence(self.room, model)
        self.prior = MotionPrior(p.forecast_sigma, p.jump_sigma, p.jump_probability, p.reach)
        self.rules = Rules(
            p.memory,
            p.drift,
            p.absence,
            p.largest_odds,
            p.silence_odds,
            p.confirmation_odds,
            p.confirmation_margin,
            p.reach,
        )
        self.existence = [Existence.unknown() for _ in self.room.targets]
        self.shown = self.usually_shown()

    def usually_shown(self) -> Array:
        """Probabilities that the views show targets of which nothing is known: (T, C)."""
        return np.full((len(self.room.targets), len(self.color)), self.params.detection)

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Candidates:
        count = len(self.existence)
        if forecast is not None and not len(forecast.state):
            forecast = None
        tracked = tracked_targets(forecast, count)
        if self.depth or (self.poor and not tracked.any()):
            self.existence, self.shown = [Existence.unknown()] * count, self.usually_shown()
            return candidates
        candidates, forecast = finite_candidates(candidates), finite_forecast(forecast)
        lost, tracked = lost_targets(forecast, count), tracked_targets(forecast, count)
        clear = self.unweighed(candidates, forecast, tracked)
        sure = candidates.targets & candidates.confirmed[:, None]
        rows = np.where(lost | sure.any(axis=0), sure, candidates.targets)
        row, target = np.nonzero(rows & ~clear)
        if not len(row):
            self.decide(Weighed.none(), forecast, tracked, clear)
            self.shown = self.usually_shown()
            return self.kept(candidates, candidates.targets & clear)
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
        return self.kept(candidates, candidates.targets & keep)

    def weighed(self, found: Hypotheses, views: Views, candidates: Candidates, lost: Array) -> Weighed:
        """The hypotheses with what speaks for them."""
        known = information(views.jacobian, precision(views.likely, views.ratio))
        chance = coincidences(known, self.color, 1 / found.variance)
        rank = ball_ratio(views.ratio, self.color, chance, self.params.other_probability)
        if self.poor:
            evidence = reflector_ratio(views.ratio, self.color, chance)
        else:
            evidence = ball_ratio(views.ratio, self.color, chance, 1.0)
        fit = np.maximum(views.ratio, 0.0).sum(axis=1) + chance[0]
        complete = np.zeros(len(found.target), bool)
        if lost.any():
            begun = found.row >= 0
            complete[begun] = appearing(candidates, lost)[found.row[begun], found.target[begun]]
        return Weighed(found.xyz, found.target, rank - found.improbability(), evidence, fit, complete)

    def remembered(self, found: Weighed, views: Views, forecast: Forecast | None, tracked: Array) -> Array:
        """Probabilities that the views show the targets in the next frame: (T, C)."""
        shown = self.usually_shown()
        persistence = self.params.persistence ** self.steps(forecast)
        for number in np.unique(found.target[tracked[found.target]]):
            mine = (found.target == number).nonzero()[0]
            best = mine[found.rank[mine].argmax()]
            known = updated(self.shown[number], views.likely.ratio[best], views.inside[best])
            shown[number] = predicted(known, self.params.detection, persistence)
        return shown

    def steps(self, forecast: Forecast | None) -> float:
        """Steps that a frame counts as, at most 1."""
        return 1.0 if forecast is None else min(forecast.period / STEP, 1.0)

    def kept(self, candidates: Candidates, targets: Array) -> Candidates:
        """The candidates that are left to targets, (N, T) bool."""
        if np.array_equal(targets, candidates.targets):
            return candidates
        return replace(candidates, targets=targets).where(np.flatnonzero(targets.any(axis=1)))

    def unweighed(self, candidates: Candidates, forecast: Forecast | None, tracked: Array) -> Array:
        """Which targets keep all their candidates: (T,) bool."""
        if not self.poor:
            return tracked & self.unambiguous(candidates)
        return ~tracked if forecast is None else ~tracked | self.settled(candidates, forecast)

    def settled(self, candidates: Candidates, forecast: Forecast) -> Array:
        """Which targets three candidates show at their forecasts, one of them in their colour: (T,) bool."""
        off = candidates.xyz[:, None] - forecast.xyz
        variance = forecast.covariance.diagonal(axis1=1, axis2=2).max(axis=1)
        there = candidates.targets & (np.vecdot(off, off) <= np.maximum(GATE**2 * variance, NEAR**2))
        own = there[candidates.labelled].any(axis=0) if self.color.any() else True
        return np.asarray((there.sum(axis=0) >= SETTLED) & own)

    def unambiguous(self, candidates: Candidates) -> Array:
        """Which targets one blob in each of four or more views shows, that all agree: (T,) bool.

        Two of them are colour and two infrared cameras where the room has both. Nothing is left to choose.
        """
        member = (candidates.view[..., None] == np.arange(len(self.color))).sum(axis=1)
        times = candidates.targets.T.astype(float) @ member
        seen = times > 0
        views = seen.sum(axis=1)
        each = ((times == views[:, None] - 1) | ~seen).all(axis=1)
        kinds = [kind for kind in (self.color, ~self.color) if kind.any()]
        both = np.all([seen[:, kind].sum(axis=1) >= CLEAR // len(kinds) for kind in kinds], axis=0)
        return np.asarray(each & both)

    def decide(self, found: Weighed, forecast: Forecast | None, tracked: Array, clear: Array) -> Array:
        """The hypotheses that hold, at most one for each target: (D,) numbers of some of the M."""
        chosen: list[int] = []
        lost = lost_targets(forecast, len(self.existence))
        sure = SETTLED_GAIN if self.poor else self.rules.bound
        for number, before in enumerate(self.existence):
            mine = (found.target == number).nonzero()[0]
            if tracked[number] and forecast is not None:
                best = int(mine[found.rank[mine].argmax()]) if len(mine) else -1
                gain = sure if clear[number] else found.evidence[best] if len(mine) else 0.0
                place, steps = forecast.xyz[number], self.steps(forecast)
                self.existence[number] = followed(before, gain, place, self.rules, steps)
                if best >= 0 and self.doubtful(found, best):
                    best = -1
            elif self.poor:
                self.existence[number], best = Existence.unknown(), -1
            else:
                near = None if forecast is None or lost[number] else forecast.xyz[number]
                others = int(np.logical_and(self.alike[number], ~tracked).sum())
                seen = Seen(found.xyz[mine], found.evidence[mine], found.complete[mine])
                self.existence[number], at = sought(before, seen, near, others, self.rules)
                best = int(mine[at]) if at >= 0 else -1
            if best >= 0 and self.existence[number].odds >= self.rules.silent:
                chosen.append(best)
        return np.array(chosen, int)

    def doubtful(self, found: Weighed, best: int) -> bool:
        """Whether a frame speaks against a place, and blobs that show it fit hardly better than clutter."""
        if self.poor:
            return False
        p = self.params
        return bool(found.evidence[best] < p.least_evidence and found.fit[best] < p.least_fit)

    def state(self) -> Any:
        existence = [{**one._asdict(), "places": one.places._asdict()} for one in self.existence]
        return {"existence": existence, "shown": self.shown}

    def restore(self, state: Any) -> None:
        self.existence = [restored(one) for one in state["existence"]]
        self.shown = np.array(state["shown"], float)
