"""Update of the tracks of people by a set of detections: association, existence, initiation, deletion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

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
)
from followspot_persons.associate.multi_view.views import Views
from followspot_persons.associate.tracks.camera_association import Association, Choice, associated, clear
from followspot_persons.associate.tracks.confirmation import confirmed, remembered
from followspot_persons.associate.tracks.track_initiation import with_initiated
from followspot_persons.associate.tracks.tracks import Tracks, predicted, shifted

TENTATIVE_DELETION = -3.0
"""Log-odds below which a track that was never confirmed is deleted."""
CONFIRMED_DELETION = -2.0
"""Log-odds below which a confirmed track is deleted."""
ROUNDS: tuple[Choice, ...] = (partial(clear, lead=4.0), partial(clear, lead=2.0), assigned)
"""How the detections of a set are assigned: those that lead over rivals by 4 nats, by 2, then the rest."""


@dataclass(frozen=True)
class Rules:
    """detection: probability that a body in full view is detected; confirmation: log-odds that confirm it;
    missed: time without a detection after which a body is deleted, ns; recalled: time after that in which its
    number is remembered, ns; area: x0, y0, x1, y1, m, or None.
    """

    detection: float
    confirmation: float
    missed: int
    recalled: int
    area: tuple[float, float, float, float] | None


def updated(
    tracks: Tracks[S], model: BodyModel[S], views: Views, detections: Sequence[Detections], rules: Rules
) -> Tracks[S]:
    """The tracks after one set of detections, those of each camera at their own time of exposure.

    That may lie before an exposure of the previous set, if cameras are out of step by more than a set.
    """
    before, tracks = tracks.time, replace(tracks, bodies=model.before_set(tracks.bodies))
    tracks, cameras = _with_detections(tracks, model, views, detections)
    weight = independence((tracks.time - before) * NANOSECOND)
    evidence = _evidence(cameras, len(tracks.bodies), rules.detection, model.odds_limits.detection)
    odds = np.clip(tracks.life.odds + evidence.change(weight), MINIMUM_ODDS, MAXIMUM_ODDS)
    tracks = replace(tracks, life=replace(tracks.life, odds=odds), unassigned=_counted(tracks, cameras))
    tracks = with_initiated(tracks, model, views, [one.unassigned for one in cameras], rules.detection)
    missed = np.pad(evidence.missed, (0, len(tracks.bodies) - len(odds)))
    tracks = confirmed(tracks, model, missed, rules.confirmation, rules.recalled)
    return _without_deleted(tracks, model, rules)


def _with_detections(
    tracks: Tracks[S], model: BodyModel[S], views: Views, detections: Sequence[Detections]
) -> tuple[Tracks[S], Sequence[Association]]:
    """The tracks after the detections of all cameras, and which belong to which.

    The most certain detections of all cameras count first: a wrong one would lead its track away, and the
    right ones of other cameras would not fit any more.
    """
    ordered = sorted(detections, key=lambda each: each.time)
    cameras = [Association.none(one, len(tracks.bodies)) for one in ordered]
    for number, choose in enumerate(ROUNDS):
        for row, one in enumerate(cameras):
            if number and one.used.all():
                continue
            tracks = predicted(tracks, model, one.detections.time)
            late = tracks.time - one.detections.time
            tracks = shifted(tracks, model, -late)
            view = views.each[one.detections.camera]
            tracks, cameras[row] = associated(tracks, model, view, one, choose)
            tracks = shifted(tracks, model, late)
    return tracks, cameras


def _evidence(
    cameras: Sequence[Association], bodies: int, detection: float, most: float
) -> ExistenceEvidence:
    """The evidence of all cameras of a set. detection: as in `Rules`; most: what a detection adds at most."""
    gain, loss, views = np.zeros(bodies), np.zeros(bodies), np.zeros(bodies, int)
    for one in cameras:
        gain, loss, views = gain + one.gain(detection, most), loss + one.loss(detection), views + one.found
    return ExistenceEvidence(gain, loss, views)


def _counted(tracks: Tracks[S], cameras: Sequence[Association]) -> Array:
    """`Tracks.unassigned` after a set: a set counts only if some person is confirmed."""
    counts = tracks.unassigned.copy()
    if (tracks.life.number > 0).any():
        for one in cameras:
            counts[one.detections.camera] += len(one.used), len(one.unassigned.measured)
    return counts


def _without_deleted(tracks: Tracks[S], model: BodyModel[S], rules: Rules) -> Tracks[S]:
    """The tracks without those that are improbable, missed for too long, or outside the area; people with a
    number are remembered.
    """
    life = tracks.life
    minimum = np.where(life.number > 0, CONFIRMED_DELETION, TENTATIVE_DELETION)
    kept = (life.odds >= minimum) & (tracks.time - life.seen <= rules.missed)
    if rules.area is not None:
        xy = model.middle(tracks.bodies)[:, :2]
        kept &= ((xy >= rules.area[:2]) & (xy <= rules.area[2:])).all(axis=1)
    gone = np.flatnonzero(~kept & (life.number > 0))
    return replace(
        tracks,
        bodies=tracks.bodies.where(kept),
        life=life.where(kept),
        lost=tracks.lost.joined(remembered(tracks, model, gone)) if len(gone) else tracks.lost,
    )
