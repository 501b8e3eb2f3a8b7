"""The people of a room: detections of each camera are assigned to them, new ones appear, others leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic, Protocol, Self, TypeVar

import numpy as np

from followspot import Array
from followspot.assignment import assigned
from followspot.frame_times import NANOSECOND
from followspot_persons.associate import looks
from followspot_persons.associate.contraction import clusters
from followspot_persons.associate.existence import (
    HIGHEST,
    LOWEST,
    Evidence,
    Tally,
    independence,
    missed,
    visible_shares,
)
from followspot_persons.associate.rows import Rows
from followspot_persons.associate.torso_colors import log_ratios
from followspot_persons.associate.views import View, Views

APART = 0.3
"""Distance within which a new body is one that is tracked already, m."""
GIVEN_UP = -3.0
"""Log-odds below which a body that was never confirmed is deleted."""
DOUBTED = -2.0
"""The same of a confirmed one."""


class Bodies(Protocol):
    """States of bodies, one row each."""

    def where(self, keep: Array) -> Self: ...
    def joined(self, other: Self) -> Self: ...
    def __len__(self) -> int: ...


S = TypeVar("S", bound=Bodies)


class BodyModel(Protocol[S]):
    """A kind of bodies: how they move, what cameras see of them, how they begin."""

    @property
    def evidence(self) -> Evidence: ...
    def none(self) -> S: ...
    def predicted(self, tracks: S, seconds: float) -> S: ...
    def fresh(self, tracks: S) -> S: ...
    def log_ratios(self, tracks: S, view: View, found: Array) -> Array: ...
    def updated(self, tracks: S, rows: Array, view: View, found: Array) -> S: ...
    def pair_ratios(self, views: Views, camera: Array, found: Array) -> Array: ...
    def born(self, views: Views, camera: Array, found: Array) -> S | None: ...
    def shifted(self, tracks: S, seconds: float) -> S: ...
    def middle(self, tracks: S) -> Array: ...
    def silhouettes(self, tracks: S, view: View) -> tuple[Array, Array]: ...


@dataclass(frozen=True, eq=False)
class Lives(Rows):
    """number: (M,) of the person, 0 until it is confirmed; odds: (M,) log-odds of existence; seen: (M,) time
    of the last detection, ns; looks: (M, C, BINS) histograms of the torso in each camera, NaN if unknown.
    """

    number: Array
    odds: Array
    seen: Array
    looks: Array


@dataclass(frozen=True)
class Rules:
    """detection: probability that a body in full view is detected; confirmation: log-odds that confirm it;
    missed: time without a detection after which a body is deleted, ns; area: x0, y0, x1, y1, m, or None.
    """

    detection: float
    confirmation: float
    missed: int
    area: tuple[float, float, float, float] | None


@dataclass(frozen=True, eq=False)
class Crowd(Generic[S]):
    """People with their states at a time, ns; numbers: how many persons there were; strangers: (C, 2) of each
    camera, its detections while there were people with numbers, and those that were none of these.
    """

    bodies: S
    lives: Lives
    time: int
    numbers: int
    strangers: Array


@dataclass(frozen=True, eq=False)
class Detections:
    """Of one camera: its number among the views, the time of exposure, ns, (N, ...) detections as the model
    takes them, and (N, BINS) histograms of their torsos, NaN if unknown.
    """

    camera: int
    time: int
    found: Array
    colors: Array


def empty_crowd(model: BodyModel[S], views: Views) -> Crowd[S]:
    """The crowd of a room in which no person is known yet."""
    lives = Lives(np.zeros(0, int), np.zeros(0), np.zeros(0, int), looks.unseen(0, len(views.each)))
    return Crowd(model.none(), lives, 0, 0, np.zeros((len(views.each), 2), int))


def after(
    crowd: Crowd[S], model: BodyModel[S], views: Views, sets: Sequence[Detections], rules: Rules
) -> Crowd[S]:
    """The people after one set of detections, each camera's at its own time of exposure.

    That may lie before an exposure of the set before, if cameras are out of step by more than a set.
    """
    before, crowd = crowd.time, replace(crowd, bodies=model.fresh(crowd.bodies))
    left, tally = [], Tally.none(len(crowd.bodies))
    strangers, known = crowd.strangers.copy(), bool((crowd.lives.number > 0).any())
    for one in sorted(sets, key=lambda each: each.time):
        crowd = _moved(crowd, model, one.time)
        late = crowd.time - one.time
        crowd = _shifted(crowd, model, -late)
        crowd, tally, free = _seen(crowd, tally, model, views.each[one.camera], one, rules)
        crowd = _shifted(crowd, model, late)
        left.append(replace(one, found=one.found[free], colors=one.colors[free]))
        strangers[one.camera] += known * np.array([len(free), np.count_nonzero(free)])
    weight = independence((crowd.time - before) * NANOSECOND)
    odds = np.clip(crowd.lives.odds + tally.change(weight), LOWEST, HIGHEST)
    crowd = replace(crowd, lives=replace(crowd.lives, odds=odds), strangers=strangers)
    crowd = _with_new(crowd, model, views, left, rules)
    return _ended(_numbered(crowd, rules), model, rules)


def as_of(crowd: Crowd[S], model: BodyModel[S], time: int) -> Crowd[S]:
    """The people at a time, ns, near that of the last exposure, for a report."""
    return _shifted(crowd, model, time - crowd.time)


def _shifted(crowd: Crowd[S], model: BodyModel[S], by: int) -> Crowd[S]:
    """The people as their motion has them some ns later, or earlier; the time of the crowd stays."""
    return replace(crowd, bodies=model.shifted(crowd.bodies, by * NANOSECOND)) if by else crowd


def _moved(crowd: Crowd[S], model: BodyModel[S], time: int) -> Crowd[S]:
    """The people at a later time."""
    if not len(crowd.bodies) or time <= crowd.time:
        return replace(crowd, time=max(time, crowd.time))
    seconds = (time - crowd.time) * NANOSECOND
    return replace(crowd, bodies=model.predicted(crowd.bodies, seconds), time=time)


def _seen(
    crowd: Crowd[S], tally: Tally, model: BodyModel[S], view: View, one: Detections, rules: Rules
) -> tuple[Crowd[S], Tally, Array]:
    """The people after one camera, what is known of their existence, and whether each detection, (N,), is
    none of them.
    """
    free = np.ones(len(one.found), bool)
    if not len(crowd.bodies):
        return crowd, tally, free
    box, depth = model.silhouettes(crowd.bodies, view)
    visible = visible_shares(box, depth, view)
    loss = missed(visible, rules.detection)
    if not len(one.found):
        return crowd, replace(tally, loss=tally.loss + loss), free
    ratio = model.log_ratios(crowd.bodies, view, one.found)
    alike = looks.agreement(crowd.lives.looks, one.camera, one.colors)
    rows, columns = assigned(np.where(ratio > 0, ratio + alike, ratio))
    bodies = model.updated(crowd.bodies, rows, view, one.found[columns])
    seen, gain, views = crowd.lives.seen.copy(), np.zeros(len(loss)), np.zeros(len(loss), int)
    gain[rows] = np.minimum(ratio[rows, columns], model.evidence.most)
    loss[rows], views[rows], seen[rows] = 0.0, 1, one.time
    free = np.asarray((ratio[crowd.lives.number > 0] <= 0).all(axis=0))
    free[columns] = False
    tally = Tally(tally.gain + gain, tally.loss + loss, tally.views + views)
    learnt = looks.learnt(crowd.lives.looks, rows, one.camera, one.colors[columns], visible[rows])
    return replace(crowd, bodies=bodies, lives=replace(crowd.lives, seen=seen, looks=learnt)), tally, free


def _with_new(
    crowd: Crowd[S], model: BodyModel[S], views: Views, left: Sequence[Detections], rules: Rules
) -> Crowd[S]:
    """The people and those that detections of two cameras or more agree on."""
    parts = [one for one in left if len(one.found)]
    if len(parts) < 2:
        return crowd
    camera = np.concatenate([np.full(len(one.found), one.camera) for one in parts])
    found = np.concatenate([one.found for one in parts])
    colors = np.concatenate([one.colors for one in parts])
    alike = log_ratios(colors[:, None], colors[None])
    for rows in clusters(model.pair_ratios(views, camera, found) + alike):
        born, rows = _agreed(model, views, camera, found, rows)
        if born is None:
            continue
        middle = model.middle(born)[0]
        if len(crowd.bodies):
            apart = np.linalg.norm(model.middle(crowd.bodies) - middle, axis=1)
            if apart.min() < APART:
                continue
        odds = model.evidence.born + model.evidence.most * len(rows)
        for c, view in enumerate(views.each):
            if c not in camera[rows]:
                box, depth = model.silhouettes(crowd.bodies.joined(born), view)
                odds += missed(visible_shares(box, depth, view), rules.detection)[-1]
        look = looks.first(len(views.each), camera[rows], colors[rows])
        lives = Lives(np.zeros(1, int), np.array([odds]), np.array([crowd.time]), look)
        crowd = replace(crowd, bodies=crowd.bodies.joined(born), lives=crowd.lives.joined(lives))
    return crowd


def _agreed(
    model: BodyModel[S], views: Views, camera: Array, found: Array, rows: Array
) -> tuple[S | None, Array]:
    """The body of a cluster, and its rows without those that contradict it; None if two are not left."""
    while len(rows) >= 2:
        born = model.born(views, camera[rows], found[rows])
        if born is None:
            return None, rows
        ratio = np.array([model.log_ratios(born, views.each[camera[r]], found[r][None])[0, 0] for r in rows])
        if (ratio > 0).all():
            return born, rows
        rows = np.delete(rows, ratio.argmin())
    return None, rows


def _numbered(crowd: Crowd[S], rules: Rules) -> Crowd[S]:
    """Confirmed people have numbers, from 1, which nobody gets twice."""
    fresh = np.flatnonzero((crowd.lives.number == 0) & (crowd.lives.odds >= rules.confirmation))
    number = crowd.lives.number.copy()
    number[fresh] = crowd.numbers + 1 + np.arange(len(fresh))
    lives = replace(crowd.lives, number=number)
    return replace(crowd, lives=lives, numbers=crowd.numbers + len(fresh))


def _ended(crowd: Crowd[S], model: BodyModel[S], rules: Rules) -> Crowd[S]:
    """The people without those that left or never were."""
    lives = crowd.lives
    lowest = np.where(lives.number > 0, DOUBTED, GIVEN_UP)
    stays = (lives.odds >= lowest) & (crowd.time - lives.seen <= rules.missed)
    if rules.area is not None:
        place = model.middle(crowd.bodies)[:, :2]
        stays &= ((place >= rules.area[:2]) & (place <= rules.area[2:])).all(axis=1)
    return replace(crowd, bodies=crowd.bodies.where(stays), lives=lives.where(stays))
