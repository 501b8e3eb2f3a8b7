"""Association of candidates with targets, and the existence of each target, weighed over all views."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from followspot import Array, Latest, Stage
from followspot.tracking import Candidates, Forecast
from followspot_balls.associate_params import AssociateParams
from followspot_balls.bundle.points import point_images
from followspot_balls.bundle.sightings import Sightings, sightings
from followspot_balls.bundle.trust import Outlines
from followspot_balls.evidence import appearing
from followspot_balls.existence import Existence, Rules, Seen, followed, restored, sought
from followspot_balls.likelihood import (
    Model,
    Sight,
    ball_ratio,
    coincidences,
    densities,
    information,
    likeliest,
    view_ratios,
)
from followspot_balls.search import lost_targets, tracked_targets
from followspot_balls.triangulate import alike

NEAREST = 1e-3
"""Smallest depth of a place that has an image, m."""
CLEAR = 4
"""Number of views that show a target clearly if nothing contradicts them."""
SHOWN = 0.1
"""Ratio of a blob's densities from which it may show the target."""


class Hypotheses(NamedTuple):
    """M places of targets."""

    xyz: Array
    """(M, 3) m."""
    target: Array
    """(M,)."""
    rank: Array
    """(M,) log-likelihood ratio, as a rival of the other hypotheses."""
    evidence: Array
    """(M,) likewise, as evidence of a ball."""
    complete: Array
    """(M,) bool, whether three views that all make pairs with each other show it."""


class Associate(Stage):
    """Keep the candidates whose blobs the likeliest place of each target explains; none if it is no ball.

    Every candidate is a hypothesis of its targets' places. All views vote on it, also those that show nothing
    there; other blobs around and other targets count as clutter. Colour cameras tell whose ball it is and
    infrared cameras that it is one, so a target needs both in the long run, where the room has both.
    """

    advice = "lower confirmation_odds, or give the room more cameras that see each place"

    class Params(AssociateParams):
        """How balls and clutter show, and how evidence moves the existence of targets."""

    params: Params

    def setup(self) -> None:
        p = self.params
        cameras = list(self.room.cameras.values())
        self.P = np.array([c.projection for c in cameras]).reshape(-1, 3, 4)
        self.centers = np.array([c.center for c in cameras]).reshape(-1, 3)
        self.focal = np.array([c.matrix[0, 0] for c in cameras])
        self.size = np.array([c.size for c in cameras], float).reshape(-1, 2)
        self.color = np.array([c.kind == "color" for c in cameras], bool)
        self.radii = np.array([t.radius for t in self.room.targets.values()])
        self.alike = alike(self.room) | ~self.color.any()
        np.fill_diagonal(self.alike, False)
        self.outlines = Outlines(self.room)
        self.model = Model(
            p.detection, p.clutter, p.neighbourhood, p.blob_sigma, p.relative_sigma, p.hidden_sigma
        )
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
        self.existence = [Existence.unknown() for _ in self.radii]

    def process(self, candidates: Candidates, forecast: Latest[Forecast] = None) -> Candidates:
        count = len(self.radii)
        if forecast is not None and not len(forecast.state):
            forecast = None
        lost, tracked = lost_targets(forecast, count), tracked_targets(forecast, count)
        clear = tracked & self.unambiguous(candidates)
        sure = candidates.targets & candidates.confirmed[:, None]
        rows = np.where(lost | sure.any(axis=0), sure, candidates.targets)
        row, target = np.nonzero(rows & ~clear)
        if not len(row):
            nothing = Hypotheses(candidates.xyz[row], target, np.zeros(0), np.zeros(0), np.zeros(0, bool))
            self.decide(nothing, forecast, tracked, clear)
            return self.kept(candidates, candidates.targets & clear)
        table = sightings(candidates, len(self.P))
        sizes = self.outlines.at_unit_depth(table.xy, table.area)
        xyz = candidates.xyz[row]
        sight, depth = self.sight(xyz, target, table, sizes)
        likely = likeliest(self.model, sight, self.rivals(table, sizes, forecast, tracked)[target])
        views = view_ratios(self.model, likely, sight.inside)
        variance, improbable = self.expectation(xyz, target, forecast, tracked)
        known = information(directions(xyz, self.centers), self.focal / depth, likely, views)
        chance = coincidences(known, self.color, 1 / variance)
        rank = ball_ratio(views, self.color, chance, self.params.other_probability) - improbable
        evidence = ball_ratio(views, self.color, chance, 1.0)
        complete = appearing(candidates, lost)[row, target] if lost.any() else np.zeros(len(row), bool)
        chosen = self.decide(Hypotheses(xyz, target, rank, evidence, complete), forecast, tracked, clear)
        mine = target[chosen]
        used = np.where(likely.ratio[chosen] > SHOWN, likely.slot[chosen], -1)
        keep = np.tile(clear, (len(candidates.xyz), 1))
        keep[:, mine] = (used[:, candidates.view] == table.slot).all(axis=2).T
        keep[row[chosen], mine] = True
        return self.kept(candidates, candidates.targets & keep)

    def kept(self, candidates: Candidates, targets: Array) -> Candidates:
        """The candidates that are left to targets, (N, T) bool."""
        if np.array_equal(targets, candidates.targets):
            return candidates
        return replace(candidates, targets=targets).where(np.flatnonzero(targets.any(axis=1)))

    def unambiguous(self, candidates: Candidates) -> Array:
        """Which targets one blob in each of four or more views shows, that all agree: (T,) bool.

        Two of them are colour and two infrared cameras where the room has both. Nothing is left to choose.
        """
        member = (candidates.view[..., None] == np.arange(len(self.P))).sum(axis=1)
        times = candidates.targets.T.astype(float) @ member
        seen = times > 0
        views = seen.sum(axis=1)
        each = ((times == views[:, None] - 1) | ~seen).all(axis=1)
        kinds = [kind for kind in (self.color, ~self.color) if kind.any()]
        both = np.all([seen[:, kind].sum(axis=1) >= CLEAR // len(kinds) for kind in kinds], axis=0)
        return np.asarray(each & both)

    def sight(self, xyz: Array, target: Array, table: Sightings, sizes: Array) -> tuple[Sight, Array]:
        """The blobs as seen from places (M, 3) m of targets (M,), and the depths of these, (M, C) m.

        sizes: (C, K) shares of a ball of unit radius at unit depth.
        """
        seen = point_images(self.P, xyz)
        off = table.xy - seen.xy[:, :, None]
        depth, radius = np.maximum(seen.depth, NEAREST), self.radii[target][:, None]
        inside = ((seen.xy >= 0) & (seen.xy < self.size)).all(axis=2) & (seen.depth > NEAREST)
        share = sizes * np.square(depth / radius)[..., None]
        possible = table.targets[target]
        return Sight(np.vecdot(off, off), share, self.focal * radius / depth, possible, inside), depth

    def rivals(self, table: Sightings, sizes: Array, forecast: Forecast | None, tracked: Array) -> Array:
        """Densities of blobs as targets other than each, where those are expected: (T, C, K) 1/px^2."""
        count = len(self.radii)
        if forecast is None or not tracked.any() or count < 2:
            return np.zeros((count, *table.area.shape))
        sight, depth = self.sight(forecast.xyz, np.arange(count), table, sizes)
        variance = forecast.covariance.diagonal(axis1=1, axis2=2).mean(axis=1)[:, None]
        spread = variance * np.square(self.focal / depth)
        density, _ = densities(self.model, sight, spread[..., None])
        density *= self.params.detection * tracked[:, None, None]
        return np.asarray(density.sum(axis=0) - density)

    def expectation(
        self, xyz: Array, target: Array, forecast: Forecast | None, tracked: Array
    ) -> tuple[Array, Array]:
        """Variance of what is known of each place along each axis, m^2, and its improbability: (M,) each."""
        anywhere = np.full(len(xyz), self.params.reach**2)
        if forecast is None:
            return anywhere, np.zeros(len(xyz))
        spread = self.params.jump_sigma**2 + forecast.covariance.diagonal(axis1=1, axis2=2).mean(axis=1)
        off = xyz - forecast.xyz[target]
        improbable = np.minimum(np.vecdot(off, off) / spread[target], self.params.largest_jump**2) / 2
        return np.where(tracked[target], spread[target], anywhere), improbable * tracked[target]

    def decide(self, found: Hypotheses, forecast: Forecast | None, tracked: Array, clear: Array) -> Array:
        """The hypotheses that hold, at most one for each target: (D,) numbers of some of the M."""
        chosen: list[int] = []
        lost = lost_targets(forecast, len(self.radii))
        for number in range(len(self.radii)):
            mine = (found.target == number).nonzero()[0]
            if tracked[number] and forecast is not None:
                best = int(mine[found.rank[mine].argmax()]) if len(mine) else -1
                gain = self.rules.bound if clear[number] else found.evidence[best] if len(mine) else 0.0
                self.existence[number] = followed(
                    self.existence[number], gain, forecast.xyz[number], self.rules
                )
            else:
                near = None if forecast is None or lost[number] else forecast.xyz[number]
                others = int(np.logical_and(self.alike[number], ~tracked).sum())
                seen = Seen(found.xyz[mine], found.evidence[mine], found.complete[mine])
                self.existence[number], at = sought(self.existence[number], seen, near, others, self.rules)
                best = int(mine[at]) if at >= 0 else -1
            if best >= 0 and self.existence[number].odds >= self.rules.silent:
                chosen.append(best)
        return np.array(chosen, int)

    def state(self) -> Any:
        return [{**one._asdict(), "places": one.places._asdict()} for one in self.existence]

    def restore(self, state: Any) -> None:
        self.existence = [restored(one) for one in state]


def directions(xyz: Array, centers: Array) -> Array:
    """Unit vectors from cameras (C, 3) m to places (M, 3) m: (M, C, 3)."""
    rays = xyz[:, None] - centers
    return np.asarray(rays / np.sqrt(np.vecdot(rays, rays))[..., None])
