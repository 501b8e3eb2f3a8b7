"""Which reported pose is which true person, frame by frame (CLEAR MOT, Bernardin & Stiefelhagen 2008)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_accuracy.persons.tables import PoseTable, PoseTruthTable
from followspot_accuracy.statistics import half_interval, nearest

REACH = 0.5
"""Largest distance on the floor at which a pose covers a person, m; farther from everybody it is false."""
LIMIT = 1.0
"""Largest distance at which a pose's errors still count as errors of a person, m."""
UNMATCHED = -1


@dataclass(frozen=True, eq=False)
class Matches:
    """Matches between the P persons of F frames and N poses.

    row: (F, P) pose of each person, -1 without one; identity: (F, P) its number if it is within `REACH`,
    else -1; frame: (N,) frame of each pose, -1 if no frame is near in time, or another pose of the same
    number is nearer; apart: (N,) m to the nearest person of the frame, inf without one.
    """

    row: Array
    identity: Array
    frame: Array
    apart: Array


def match(poses: PoseTable, truth: PoseTruthTable) -> Matches:
    """Match by time within half an interval of the truth, then by distance on the floor.

    An earlier match is kept while it is within `REACH`; the remaining poses are matched nearest
    first.
    """
    frames, persons = truth.visible.shape
    row = np.full((frames, persons), UNMATCHED)
    identity = np.full((frames, persons), UNMATCHED)
    frame = frame_of(poses, truth.time)
    apart = np.full(len(poses.time), np.inf)
    held = np.full(persons, UNMATCHED)
    order = np.argsort(frame, kind="stable")
    starts = np.searchsorted(frame[order], np.arange(frames + 1))
    for f in range(frames):
        rows = order[starts[f] : starts[f + 1]]
        away = np.linalg.norm(poses.pose[rows, None, :2] - truth.pose[None, f, :, :2], axis=2)
        away[np.isnan(away)] = np.inf
        apart[rows] = away.min(axis=1, initial=np.inf)
        kept = (poses.person[rows, None] == held) & (away <= REACH)
        for r, p in pairs(np.where(kept, away - LIMIT, away)):
            row[f, p] = rows[r]
            if away[r, p] <= REACH:
                identity[f, p] = held[p] = poses.person[rows[r]]
    return Matches(row, identity, frame, apart)


def frame_of(poses: PoseTable, time: Array) -> Array:
    """(N,) the frame that each pose belongs to; -1 for none."""
    if not len(time) or not len(poses.time):
        return np.full(len(poses.time), UNMATCHED)
    frame, late = nearest(time, poses.time)
    _, group = np.unique(np.column_stack([frame, poses.person]), axis=0, return_inverse=True)
    soonest = np.full(len(frame), np.inf)
    np.minimum.at(soonest, group.ravel(), late)
    return np.where((late == soonest[group.ravel()]) & (late <= half_interval(time)), frame, UNMATCHED)


def pairs(cost: Array) -> list[tuple[int, int]]:
    """Row and column of the smallest entry up to `LIMIT`, then of the smallest of other rows and columns."""
    left = cost.copy()
    found = []
    while left.size and left.min() <= LIMIT:
        r, p = divmod(int(left.argmin()), left.shape[1])
        found.append((r, p))
        left[r] = left[:, p] = np.inf
    return found
