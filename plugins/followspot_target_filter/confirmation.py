"""Confirmation of tentative targets by candidates of one or several frames (Jin & Qian 2008, section 3.8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from followspot.messages import Array
from followspot.tracking import LOST, MISSING, Positions
from followspot_target_filter.life_cycle import LifeCycle, has_position, missing_long


@dataclass(frozen=True)
class ConfirmationRules:
    """Conditions for confirming a target: enough candidates in one frame, or evident ones in several."""

    support: int
    """Candidates that confirm it if they agree in one frame."""
    frames: int
    """Successive frames with an evident candidate that confirm it otherwise: one colour-infrared pair may be
    a coincidence, several in a row hardly are."""
    maximum_step: float
    """m, largest distance of such a candidate from the one in the previous frame; a position with a larger
    sigma is uncertain."""
    separation: float
    """m; a position that is nearer than this to another target belongs to that target."""
    return_distance: float
    """m; a missing target within this distance of its last position has stayed there."""
    established: int
    """Measurements since it was last lost from which a target is surely true."""


class LastPositions(NamedTuple):
    """Last positions of T targets, (T, 3) m each."""

    last: Array
    """The last one."""
    measured: Array
    """The last one that was measured, not predicted from one view."""


def confirmed(
    life: LifeCycle,
    status: Array,
    local_frames: int,
    positions: Positions,
    last: LastPositions,
    rules: ConfirmationRules,
) -> tuple[LifeCycle, Array]:
    """Which measurements count: those of tracked targets, and those that confirm a tentative target.

    Only confirmed pairs recover a target that was searched as lost, and only two frames in a row find a
    doubted one elsewhere.
    status, local_frames: of :func:`followspot_target_filter.life_cycle.search_status`. Returns the life
    cycle with new streaks, and (M,) bool.
    """
    target, xyz = positions.target, positions.xyz
    kept = missing_long(life, local_frames)
    if np.count_nonzero(kept):
        kept &= (status == MISSING) != within(life.candidate, last.last, rules.return_distance)
    streak = life.streak * kept
    status, before = status.take(target), life.status.take(target)
    known = has_position(status)
    if np.count_nonzero(known) == len(known):
        return life._replace(streak=streak), known
    possible = (positions.support > 0) & (positions.confirmed | (status != LOST)) & ~positions.predicted
    possible &= ~occupied(xyz, known, rules.separation)
    again = np.linalg.norm(xyz - life.candidate[target], axis=1) <= rules.maximum_step
    # A target missing nearby needs one candidate less.
    near_by = (status == MISSING) & (before == MISSING)
    agreeing = supported(positions, rules.support, less=near_by)
    # One candidate alone confirms a target where it was last measured, an unconfirmed one within half of
    # `return_distance`. Only targets with many measurements come back so easily: the others may be false.
    stayed = rules.return_distance * np.where(positions.confirmed, 1.0, 0.5)
    back = near_by & (life.hits.take(target) >= rules.established)
    agreeing |= back & within(xyz, last.measured[target], stayed)
    # One view alone may have led it to its last position: a candidate there is half of what confirms it.
    there = back & within(xyz, last.last[target], rules.return_distance)
    shown = np.where(there, (rules.frames + 1) // 2, positions.evident)
    shown = np.where(agreeing, rules.frames, shown)
    row = np.where(possible, np.where(again, life.streak[target], 0) + shown, 0)
    # Uncertain positions of lost targets, and those elsewhere of doubted ones, need twice as many frames.
    twice = (status == LOST) & (has_position(before) | uncertain(positions, rules))
    strong = possible & (shown > 0) & (row >= rules.frames * (1 + twice))
    candidate = life.candidate.copy()
    streak[target], candidate[target] = row, xyz
    return life._replace(streak=streak, candidate=candidate), known | strong


def supported(positions: Positions, support: int, less: Array | int = 0) -> Array:
    """Positions that enough candidates agree on, two if one of them is evident: (M,) bool.

    support: candidates that are enough if none is; less: (M,) by how many fewer are enough.
    """
    return np.asarray(positions.support >= np.where(positions.evident, min(2, support), support) - less)


def within(xyz: Array, center: Array, distance: Array | float) -> Array:
    """Which of M points are nearer to their centres than a distance: (M, 3) m each, and m -> (M,) bool."""
    return np.asarray(np.linalg.norm(xyz - center, axis=1) < distance)


def uncertain(positions: Positions, rules: ConfirmationRules) -> Array:
    """Positions whose sigma exceeds `maximum_step`, because other places are nearly as likely: (M,) bool.

    A position on which twice as many candidates agree as are needed is certain all the same.
    """
    variance = positions.covariance.diagonal(axis1=1, axis2=2).max(axis=1)
    return np.asarray((variance > rules.maximum_step**2) & (positions.support < 2 * rules.support))


def occupied(xyz: Array, known: Array, separation: float) -> Array:
    """Which tentative targets are at the position of another target that is known or comes first.

    xyz: (M, 3) m; known: (M,) bool; separation: m. Returns (M,) bool.
    """
    offset = xyz[:, None] - xyz
    beside = np.vecdot(offset, offset) < separation * separation
    first = known | np.tri(len(xyz), k=-1, dtype=bool)
    np.fill_diagonal(first, False)
    return np.asarray((beside & first).any(axis=1) & ~known)
