"""The life cycle of a target: tentative, confirmed, coasting, deleted (Jin & Qian 2008, section 3.8).

A lost target that shows candidates is tentative. Enough evidence confirms it: its status is TRACKED. Without
measurements it coasts as MISSING, or as PREDICTED while one view bridges the gap, and is deleted after some
frames: it is LOST again. A track that few candidates have shown for long is doubted: it may have left its
target, so that is also sought elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from followspot.messages import Array
from followspot.tracking import LOST, MISSING, PREDICTED, TRACKED, Positions

EVERY = 5
"""A doubted target is sought everywhere in every fifth frame, and in the next one if it was found elsewhere:
what two frames show is no coincidence."""
DEPARTURES = 0.3
"""Rate at which tracks that few candidates show leave their targets, 1/s."""
AWAY = 0.16
"""How far off such a track is then along each axis, m, root mean square."""


@dataclass(frozen=True)
class Evidence:
    """What confirms a tentative target: enough candidates in one frame, or evident ones in several."""

    support: int
    """Candidates that confirm it if they agree in one frame."""
    frames: int
    """Successive frames with an evident candidate that confirm it otherwise: one colour-infrared pair may be
    a coincidence, several in a row hardly are."""
    reach: float
    """m, largest distance of such a candidate from the one in the frame before; a position with a larger
    sigma is vague."""
    apart: float
    """m; a position that is nearer than this to another target belongs to that target."""
    back: float
    """m; a missing target within this distance of its last position has stayed there."""
    many: int
    """Measurements since it was last lost from which a target is surely true."""


class Left(NamedTuple):
    """Where T missing targets were, (T, 3) m each."""

    last: Array
    """Last position."""
    measured: Array
    """The last that was measured, not predicted from one view."""


class LifeCycle(NamedTuple):
    """The life cycles of T targets."""

    status: Array
    """(T,) u8: LOST, TRACKED, MISSING or PREDICTED."""
    missed: Array
    """(T,) frames since the last measurement: the paper's missing-frame counter."""
    hits: Array
    """(T,) frames with a measurement since the target was last lost."""
    streak: Array
    """(T,) successive frames with an evident candidate of a tentative target; one in which candidates agree
    counts as many as confirm it. A frame in which a roaming target was sought near its last position does not
    count and does not end the streak; nor does a search everywhere, if the streak is there."""
    place: Array
    """(T, 3) m, the candidate in the last of these frames."""
    poor: Array
    """(T,) frames in a row with a position that fewer candidates show than confirm a target, from the first
    measurement of that kind on."""

    @classmethod
    def lost(cls, count: int) -> Self:
        """All targets lost."""
        zeros = np.zeros(count, int)
        return cls(np.full(count, LOST, np.uint8), zeros, zeros, zeros, np.zeros((count, 3)), zeros)


def roaming(life: LifeCycle, near: int) -> Array:
    """Missing targets that have not reappeared near their last position for `near` frames: (T,) bool."""
    return np.asarray((life.status == MISSING) & (life.missed > near))


def followed(status: Array) -> Array:
    """Targets that have a position: (T,) bool. status: (T,) u8."""
    return np.asarray((status == TRACKED) | (status == PREDICTED))


def doubted(life: LifeCycle, doubt_frames: int) -> Array:
    """Tracked targets to be sought elsewhere, too: few candidates have shown them for long. (T,) bool.

    doubt_frames: successive frames with few candidates after which a target is doubted; 0: never.
    """
    beyond = life.poor - doubt_frames
    if not doubt_frames or beyond.max(initial=-1) < 0:
        return np.zeros(len(beyond), bool)
    first = (beyond % EVERY == 0) & (life.status == TRACKED)
    again = (beyond % EVERY == 1) & followed(life.status) & (life.streak > 0)
    return np.asarray((beyond >= 0) & (first | again))


def departure_variance(seconds: Array) -> Array:
    """Variance along each axis, m^2, of where targets are whose tracks may have left them, of any shape.

    The filter takes errors of successive frames as independent, but what leads a track away does so in all.
    seconds: for which few candidates have shown each.
    """
    return np.asarray(-np.expm1(-DEPARTURES * seconds) * AWAY**2)


def sought(life: LifeCycle, near: int, marked: Array, doubted: Array) -> Array:
    """The status that decides where the next frame is searched: (T,) u8.

    A roaming target counts as lost in every second frame; near: frames before it roams. A doubted one counts
    as lost; doubted: (T,) bool. A lost target with a mark counts as missing there, unless it is the only one
    that is not tracked; marked: (T,) bool.
    """
    status = life.status.copy()
    status[doubted] = LOST
    everywhere = roaming(life, near)
    if everywhere.any():
        status[everywhere & ((life.missed - near) % 2 == 1)] = LOST
    if marked.any() and np.count_nonzero(life.status == TRACKED) < len(marked) - 1:
        status[marked & (life.status == LOST)] = MISSING
    return status


def confirmed(
    life: LifeCycle, status: Array, near: int, positions: Positions, left: Left, evidence: Evidence
) -> tuple[LifeCycle, Array]:
    """Which measurements count: those of tracked targets, and those that confirm a tentative target.

    Only confirmed pairs recover a target that was sought as lost, and only two frames in a row find a doubted
    one elsewhere.
    status, near: of :func:`sought`. Returns the life cycle with new streaks, and (M,) bool.
    """
    target, xyz = positions.target, positions.xyz
    kept = roaming(life, near)
    if kept.any():
        kept &= (status == MISSING) != close(life.place, left.last, evidence.back)
    streak = life.streak * kept
    status, before = status.take(target), life.status.take(target)
    known = followed(status)
    if known.all():
        return life._replace(streak=streak), known
    possible = (positions.support > 0) & (positions.confirmed | (status != LOST)) & ~positions.predicted
    possible &= ~occupied(xyz, known, evidence.apart)
    again = np.linalg.norm(xyz - life.place[target], axis=1) <= evidence.reach
    # Two candidates are enough if one of them is evident; a target missing nearby needs one less.
    near_by = (status == MISSING) & (before == MISSING)
    agreeing = positions.support >= np.where(positions.evident, 2, evidence.support) - near_by
    # One candidate alone confirms a target where it was last measured, an unconfirmed one within half of
    # `back`. Only targets with many measurements come back so easily: the others may be false.
    stayed = evidence.back * np.where(positions.confirmed, 1.0, 0.5)
    back = near_by & (life.hits.take(target) >= evidence.many)
    agreeing |= back & close(xyz, left.measured[target], stayed)
    # One view alone may have led it to its last position: a candidate there is half of what confirms it.
    there = back & close(xyz, left.last[target], evidence.back)
    shown = np.where(there, (evidence.frames + 1) // 2, positions.evident)
    shown = np.where(agreeing, evidence.frames, shown)
    row = np.where(possible, np.where(again, life.streak[target], 0) + shown, 0)
    # A vague position of a lost target, and one elsewhere of a doubted target, need twice as many frames.
    twice = (status == LOST) & (followed(before) | vague(positions, evidence))
    strong = possible & (shown > 0) & (row >= evidence.frames * (1 + twice))
    place = life.place.copy()
    streak[target], place[target] = row, xyz
    return life._replace(streak=streak, place=place), known | strong


def close(xyz: Array, place: Array, reach: Array | float) -> Array:
    """Which of M points are nearer than that to places: (M, 3) m each, and m -> (M,) bool."""
    return np.asarray(np.linalg.norm(xyz - place, axis=1) < reach)


def vague(positions: Positions, evidence: Evidence) -> Array:
    """Positions whose sigma exceeds `reach`, because other places are nearly as likely: (M,) bool.

    What twice as many candidates agree on as are needed is no chance, whatever else there is.
    """
    variance = positions.covariance.diagonal(axis1=1, axis2=2).max(axis=1)
    return np.asarray((variance > evidence.reach**2) & (positions.support < 2 * evidence.support))


def occupied(xyz: Array, known: Array, apart: float) -> Array:
    """Which tentative targets are at the position of another target that is known or comes first.

    xyz: (M, 3) m; known: (M,) bool; apart: m. Returns (M,) bool.
    """
    offset = xyz[:, None] - xyz
    beside = np.vecdot(offset, offset) < apart * apart
    first = known | np.tri(len(xyz), k=-1, dtype=bool)
    np.fill_diagonal(first, False)
    return np.asarray((beside & first).any(axis=1) & ~known)


def poor_counted(life: LifeCycle, measured: Array, agreed: Array) -> LifeCycle:
    """The life cycle with the counters of poor frames one frame later.

    What one view alone shows from the beginning is not poor: no more can be asked of it.
    measured, agreed: (T,) bool, targets with a measurement, and with one by as many candidates as confirm it.
    """
    return life._replace(poor=np.where(agreed, 0, life.poor + (measured | (life.poor > 0))))


def coasted(life: LifeCycle, measured: Array, bridged: Array, maximum_missed: int) -> LifeCycle:
    """The life cycle one frame later: measured targets are tracked, others coast or are deleted.

    A target is deleted after `maximum_missed` frames without a measurement, or after as many as it had
    measurements, because a target with few of them may be false.
    measured, bridged: (T,) bool; a bridged target is PREDICTED instead of MISSING.
    """
    hits = life.hits + measured
    if measured.all():
        status = np.full(len(hits), TRACKED, np.uint8)
        return life._replace(status=status, missed=np.zeros(len(hits), int), hits=hits)
    missed = np.where(measured, 0, life.missed + 1)
    coasting = ~measured & (life.status != LOST) & (missed <= np.minimum(hits, maximum_missed))
    absent = np.where(coasting, np.where(bridged, PREDICTED, MISSING), LOST)
    status = np.where(measured, TRACKED, absent).astype(np.uint8)
    there = status != LOST
    return life._replace(status=status, missed=missed, hits=hits * there, poor=life.poor * there)
