"""When a target is tracked, missing or lost, and what recovers it (Jin & Qian 2008, section 3.8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from followspot.messages import Array
from followspot.tracking import LOST, MISSING, PREDICTED, TRACKED, Positions


@dataclass(frozen=True)
class Evidence:
    """What a target that is not tracked must show before its position is believed.

    support: candidates that agree in one frame, or two if one of them is evident by itself; or else so many
    frames that show an evident one, each within reach (m) of the last. One colour-infrared pair may be a
    coincidence, but hardly again and again.
    """

    support: int
    frames: int
    reach: float
    apart: float
    """m, less than any two targets can be: what is nearer to another one is that one."""


class LifeCycle(NamedTuple):
    """Of T targets."""

    status: Array
    """(T,) u8: LOST, TRACKED, MISSING or PREDICTED."""
    unseen: Array
    """(T,) frames since the target was last measured: the paper's missing-frame counter."""
    seen: Array
    """(T,) frames in which it was measured since it was last lost."""
    streak: Array
    """(T,) frames in a row that showed a target which is not tracked yet; one in which a target that roams
    was sought near its last place does not end the row."""
    place: Array
    """(T, 3) m, where the last of them showed it."""

    @classmethod
    def lost(cls, count: int) -> Self:
        """All targets lost."""
        zeros = np.zeros(count, int)
        return cls(np.full(count, LOST, np.uint8), zeros, zeros, zeros, np.zeros((count, 3)))


def roaming(life: LifeCycle, near: int) -> Array:
    """Missing targets that may be anywhere, not back at their last place after `near` frames: (T,) bool."""
    return np.asarray((life.status == MISSING) & (life.unseen > near))


def sought(life: LifeCycle, near: int) -> Array:
    """As what the targets are sought in the next frame: (T,) u8.

    One that roams is sought as if it were lost in every second frame; near: frames before it does.
    """
    everywhere = roaming(life, near)
    if not everywhere.any():
        return life.status.copy()
    everywhere &= (life.unseen - near) % 2 == 1
    return np.where(everywhere, np.uint8(LOST), life.status)


def believed(
    life: LifeCycle, status: Array, near: int, positions: Positions, evidence: Evidence
) -> tuple[LifeCycle, Array]:
    """Which measurements count: all of tracked targets, of others those with enough evidence.

    What was sought as lost is recovered by colour-infrared pairs only. status: (T,) as what the targets were
    `sought`; near: likewise. Returns the life cycle with its streaks moved on, and (M,) bool.
    """
    target, xyz = positions.target, positions.xyz
    streak = np.where(roaming(life, near) & (status == MISSING), life.streak, 0)
    status = status.take(target)
    known = (status == TRACKED) | (status == PREDICTED)
    if known.all():
        return life._replace(streak=streak), known
    possible = (positions.support > 0) & (positions.confirmed | (status != LOST)) & ~positions.predicted
    possible &= ~occupied(xyz, known, evidence.apart)
    again = np.linalg.norm(xyz - life.place[target], axis=1) <= evidence.reach
    row = np.where(possible, np.where(again, life.streak[target], 0) + positions.evident, 0)
    agreeing = positions.support >= np.where(positions.evident, 2, evidence.support)
    strong = possible & (agreeing | (row >= evidence.frames))
    place = life.place.copy()
    streak[target], place[target] = row, xyz
    return LifeCycle(life.status, life.unseen, life.seen, streak, place), known | strong


def occupied(xyz: Array, known: Array, apart: float) -> Array:
    """Which targets that are not known seem to be where another one is, that is known or comes first.

    xyz: (M, 3) m; known: (M,) bool; apart: m. Returns (M,) bool.
    """
    offset = xyz[:, None] - xyz
    beside = np.vecdot(offset, offset) < apart * apart
    first = known | np.tri(len(xyz), k=-1, dtype=bool)
    np.fill_diagonal(first, False)
    return np.asarray((beside & first).any(axis=1) & ~known)


def aged(life: LifeCycle, measured: Array, bridged: Array, patience: int) -> LifeCycle:
    """One frame later: measured targets are tracked, others missing, and lost after `patience` frames.

    A target that was seen in fewer frames than that is lost after as many: it may never have been there.
    measured, bridged: (T,) bool; a bridged target is predicted instead of missing.
    """
    seen = life.seen + measured
    if measured.all():
        status = np.full(len(seen), TRACKED, np.uint8)
        return LifeCycle(status, np.zeros(len(seen), int), seen, life.streak, life.place)
    unseen = np.where(measured, 0, life.unseen + 1)
    waiting = ~measured & (life.status != LOST) & (unseen <= np.minimum(seen, patience))
    absent = np.where(waiting, np.where(bridged, PREDICTED, MISSING), LOST)
    status = np.where(measured, TRACKED, absent).astype(np.uint8)
    return LifeCycle(status, unseen, seen * (status != LOST), life.streak, life.place)
