"""Update of the tracks of people by a set of detections: association, existence, initiation, deletion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Array
from followspot.assignment import assigned
from followspot.frame_times import NANOSECOND
from followspot_persons.associate.body_model import BodyModel, S
from followspot_persons.associate.detections import Detections
from followspot_persons.associate.existence import (
    MAXIMUM_ODDS,
    MINIMUM_ODDS,
    ExistenceEvidence,
    independence,
    missed_detection,
    visible_shares,
)
from followspot_persons.associate.track_colors import color_log_ratios, updated_colors
from followspot_persons.associate.track_initiation import with_initiated
from followspot_persons.associate.tracks import Tracks, predicted, shifted
from followspot_persons.associate.views import View, Views

TENTATIVE_DELETION = -3.0
"""Log-odds below which a track that was never confirmed is deleted."""
CONFIRMED_DELETION = -2.0
"""Log-odds below which a confirmed track is deleted."""


@dataclass(frozen=True)
class Rules:
    """detection: probability that a body in full view is detected; confirmation: log-odds that confirm it;
    missed: time without a detection after which a body is deleted, ns; area: x0, y0, x1, y1, m, or None.
    """

    detection: float
    confirmation: float
    missed: int
    area: tuple[float, float, float, float] | None


def updated(
    tracks: Tracks[S], model: BodyModel[S], views: Views, detections: Sequence[Detections], rules: Rules
) -> Tracks[S]:
    """The tracks after one set of detections, those of each camera at their own time of exposure.

    That may lie before an exposure of the previous set, if cameras are out of step by more than a set.
    """
    before, tracks = tracks.time, replace(tracks, bodies=model.before_set(tracks.bodies))
    remaining, evidence = [], ExistenceEvidence.none(len(tracks.bodies))
    unassigned, any_confirmed = tracks.unassigned.copy(), bool((tracks.life.number > 0).any())
    for one in sorted(detections, key=lambda each: each.time):
        tracks = predicted(tracks, model, one.time)
        late = tracks.time - one.time
        tracks = shifted(tracks, model, -late)
        tracks, evidence, free = _associated(tracks, evidence, model, views.each[one.camera], one, rules)
        tracks = shifted(tracks, model, late)
        remaining.append(replace(one, measured=one.measured[free], colors=one.colors[free]))
        unassigned[one.camera] += any_confirmed * np.array([len(free), np.count_nonzero(free)])
    weight = independence((tracks.time - before) * NANOSECOND)
    odds = np.clip(tracks.life.odds + evidence.change(weight), MINIMUM_ODDS, MAXIMUM_ODDS)
    tracks = replace(tracks, life=replace(tracks.life, odds=odds), unassigned=unassigned)
    tracks = with_initiated(tracks, model, views, remaining, rules.detection)
    return _without_deleted(_confirmed(tracks, rules), model, rules)


def _associated(
    tracks: Tracks[S],
    evidence: ExistenceEvidence,
    model: BodyModel[S],
    view: View,
    one: Detections,
    rules: Rules,
) -> tuple[Tracks[S], ExistenceEvidence, Array]:
    """The tracks and the evidence after one camera, and whether each detection, (N,), is unassigned."""
    free = np.ones(len(one.measured), bool)
    if not len(tracks.bodies):
        return tracks, evidence, free
    box, depth = model.bounding_boxes(tracks.bodies, view)
    visible = visible_shares(box, depth, view)
    loss = missed_detection(visible, rules.detection)
    if not len(one.measured):
        return tracks, replace(evidence, loss=evidence.loss + loss), free
    ratio = model.log_ratios(tracks.bodies, view, one.measured)
    color_ratio = color_log_ratios(tracks.life.colors, one.camera, one.colors)
    rows, columns = assigned(np.where(ratio > 0, ratio + color_ratio, ratio))
    bodies = model.updated(tracks.bodies, rows, view, one.measured[columns])
    seen, gain, views = tracks.life.seen.copy(), np.zeros(len(loss)), np.zeros(len(loss), int)
    gain[rows] = np.minimum(ratio[rows, columns], model.odds_limits.detection)
    loss[rows], views[rows], seen[rows] = 0.0, 1, one.time
    free = np.asarray((ratio[tracks.life.number > 0] <= 0).all(axis=0))
    free[columns] = False
    evidence = ExistenceEvidence(evidence.gain + gain, evidence.loss + loss, evidence.views + views)
    colors = updated_colors(tracks.life.colors, rows, one.camera, one.colors[columns], visible[rows])
    return replace(tracks, bodies=bodies, life=replace(tracks.life, seen=seen, colors=colors)), evidence, free


def _confirmed(tracks: Tracks[S], rules: Rules) -> Tracks[S]:
    """The tracks, of which those that are confirmed now get new numbers, from 1."""
    new = np.flatnonzero((tracks.life.number == 0) & (tracks.life.odds >= rules.confirmation))
    number = tracks.life.number.copy()
    number[new] = tracks.numbers + 1 + np.arange(len(new))
    return replace(tracks, life=replace(tracks.life, number=number), numbers=tracks.numbers + len(new))


def _without_deleted(tracks: Tracks[S], model: BodyModel[S], rules: Rules) -> Tracks[S]:
    """The tracks without those that are improbable, missed for too long, or outside the area."""
    life = tracks.life
    minimum = np.where(life.number > 0, CONFIRMED_DELETION, TENTATIVE_DELETION)
    kept = (life.odds >= minimum) & (tracks.time - life.seen <= rules.missed)
    if rules.area is not None:
        xy = model.middle(tracks.bodies)[:, :2]
        kept &= ((xy >= rules.area[:2]) & (xy <= rules.area[2:])).all(axis=1)
    return replace(tracks, bodies=tracks.bodies.where(kept), life=life.where(kept))
