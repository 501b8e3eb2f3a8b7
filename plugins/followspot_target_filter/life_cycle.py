"""The life cycle of a target: tentative, confirmed, coasting, deleted (Jin & Qian 2008, section 3.8).

A lost target that shows candidates is tentative. Enough evidence confirms it: its status is TRACKED. Without
measurements it coasts as MISSING, or as PREDICTED while one view bridges the gap, and is deleted after some
frames: it is LOST again.
"""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from followspot.messages import Array
from followspot.tracking import LOST, MISSING, PREDICTED, TRACKED


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
    counts as many as confirm it. While a target is missing for long, frames that were searched near its last
    position do not end a streak elsewhere, and frames that were searched everywhere do not end one there."""
    candidate: Array
    """(T, 3) m, the candidate in the last of these frames."""
    weak: Array
    """(T,) frames in a row with a position that fewer candidates show than confirm a target, or only those of
    cameras of one kind where both look, from the first such measurement on."""

    @classmethod
    def lost(cls, count: int) -> Self:
        """All targets lost."""
        zeros = np.zeros(count, int)
        return cls(np.full(count, LOST, np.uint8), zeros, zeros, zeros, np.zeros((count, 3)), zeros)


def missing_long(life: LifeCycle, local_frames: int) -> Array:
    """Missing targets that did not reappear near their last position for `local_frames`: (T,) bool."""
    return np.asarray((life.status == MISSING) & (life.missed > local_frames))


def has_position(status: Array) -> Array:
    """Targets that have a position: (T,) bool. status: (T,) u8."""
    return np.asarray((status == TRACKED) | (status == PREDICTED))


def search_status(life: LifeCycle, local_frames: int, marked: Array, doubted: Array) -> Array:
    """The status that decides where the next frame is searched: (T,) u8.

    A target that is missing for more than `local_frames` counts as lost in every second frame. A doubted one
    counts as lost; doubted: (T,) bool. A lost target with a mark counts as missing there, unless it is the
    only one that is not tracked; marked: (T,) bool.
    """
    status = life.status.copy()
    status[doubted] = LOST
    everywhere = missing_long(life, local_frames)
    if np.count_nonzero(everywhere):
        status[everywhere & ((life.missed - local_frames) % 2 == 1)] = LOST
    if np.count_nonzero(marked) and np.count_nonzero(life.status == TRACKED) < len(marked) - 1:
        status[marked & (life.status == LOST)] = MISSING
    return status


def with_weak_counted(life: LifeCycle, measured: Array, agreed: Array) -> LifeCycle:
    """The life cycle with the counters of weak frames one frame later.

    A target that one view alone has shown from the beginning is not weak: more support cannot be expected.
    measured, agreed: (T,) bool, targets with a measurement, and with one by as many candidates as confirm it.
    """
    return life._replace(weak=np.where(agreed, 0, life.weak + (measured | (life.weak > 0))))


def coasted(life: LifeCycle, measured: Array, bridged: Array, maximum_missed: int) -> LifeCycle:
    """The life cycle one frame later: measured targets are tracked, others coast or are deleted.

    A target is deleted after `maximum_missed` frames without a measurement, or after as many as it had
    measurements, because a target with few of them may be false.
    measured, bridged: (T,) bool; a bridged target is PREDICTED instead of MISSING.
    """
    hits = life.hits + measured
    if np.count_nonzero(measured) == len(measured):
        status = np.full(len(hits), TRACKED, np.uint8)
        return life._replace(status=status, missed=np.zeros(len(hits), int), hits=hits)
    missed = np.where(measured, 0, life.missed + 1)
    coasting = ~measured & (life.status != LOST) & (missed <= np.minimum(hits, maximum_missed))
    absent = np.where(coasting, np.where(bridged, PREDICTED, MISSING), LOST)
    status = np.where(measured, TRACKED, absent).astype(np.uint8)
    there = status != LOST
    return life._replace(status=status, missed=missed, hits=hits * there, weak=life.weak * there)
