"""How well all persons together were tracked: MOTA (CLEAR MOT, Bernardin & Stiefelhagen 2008) and IDF1
(Ristani et al. 2016).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot.assignment import assigned
from followspot.messages import Array
from followspot_accuracy.persons.matching import REACH, UNMATCHED, frame_of
from followspot_accuracy.persons.tables import PoseTable, PoseTruthTable
from followspot_accuracy.persons.visits import SEEN

Area = tuple[float, float, float, float]
"""Part of the floor that the truth covers: x0, y0, x1, y1, m."""
_CLOSER = 1e3
"""Worth of a pair over its distance in gates: as many pairs as possible, then the nearest."""
_KEPT = 1e6
"""Further worth of a pair that was together before."""


@dataclass(frozen=True)
class Tracking:
    """Counts over all frames. Persons of whom less than half is seen, and those outside the area, need not be
    found; their poses are neither right nor false.
    """

    truths: int
    """Places of persons that had to be found."""
    missed: int
    false: int
    """Poses that belong to no person, in the area or near a person that had to be found."""
    switches: int
    """Changes of a person's number from one place that was found to the next."""
    mota: float
    """1 - (missed + false + switches) / truths."""
    idf1: float
    """Share of right places if each person has one number, the best, in all frames."""
    mean_m: float
    """Mean distance on the floor of the places that were found."""


@dataclass(frozen=True, eq=False)
class Correspondence:
    """pose: (F, P) row of each person's pose, -1 for none; needed: (F, P) whether it had to be found; counts:
    (N,) whether a pose is right or false.
    """

    pose: Array
    needed: Array
    counts: Array


def tracking(
    poses: PoseTable, truth: PoseTruthTable, area: Area | None = None, gate: float = REACH
) -> Tracking:
    """Compare poses with the truth. area: that the truth covers, None for all; gate: m."""
    frame = frame_of(poses, truth.time)
    found = correspondence(poses, truth, frame, area, gate)
    right = (found.pose != UNMATCHED) & found.needed
    rows = found.pose[right]
    truths, false = int(found.needed.sum()), int(found.counts.sum()) - len(rows)
    number = np.append(poses.person, UNMATCHED)[found.pose]
    missed, switches = truths - len(rows), _mota_switches(number)
    distance = np.linalg.norm(poses.pose[rows, :2] - truth.pose[right][:, :2], axis=1)
    return Tracking(
        truths=truths,
        missed=missed,
        false=false,
        switches=switches,
        mota=1 - (missed + false + switches) / truths if truths else np.nan,
        idf1=_idf1(poses, truth, frame, found, gate),
        mean_m=float(distance.mean()) if len(rows) else np.nan,
    )


def correspondence(
    poses: PoseTable, truth: PoseTruthTable, frame: Array, area: Area | None, gate: float
) -> Correspondence:
    """Which pose is which person's. frame: (N,) of each pose.

    A person keeps the number that it had last while that is within the gate; the others are assigned so that
    as many as possible are found, at the least sum of distances.
    """
    place = truth.pose[..., :2]
    present = np.isfinite(place).all(axis=2)
    needed = present & (truth.visible >= SEEN) & within(place, area)
    pose = np.full(present.shape, UNMATCHED)
    counts = frame != UNMATCHED
    last = np.full(present.shape[1], UNMATCHED)
    for f in range(len(pose)):
        rows = np.flatnonzero(frame == f)
        away = np.linalg.norm(poses.pose[rows, None, :2] - place[f], axis=2)
        near = away <= gate
        kept = near & (poses.person[rows, None] == last)
        r, p = assigned(np.where(near, _KEPT * kept + _CLOSER - away / gate, 0.0))
        pose[f, p] = rows[r]
        last[p] = poses.person[rows[r]]
        inside = within(poses.pose[rows, :2], area) | (near & needed[f]).any(axis=1)
        inside[r] = needed[f, p]
        counts[rows] &= inside
    return Correspondence(pose, needed, counts)


def within(place: Array, area: Area | None) -> Array:
    """Whether places (..., 2) m are in the area."""
    if area is None:
        return np.ones(place.shape[:-1], bool)
    low, high = np.array(area[:2]), np.array(area[2:])
    return np.asarray(((place >= low) & (place <= high)).all(axis=-1))


def _mota_switches(number: Array) -> int:
    """Changes of the numbers of all persons, as MOTA counts them. number: (F, P), -1 for none."""
    own = [column[column != UNMATCHED] for column in number.T]
    return sum(int((each[1:] != each[:-1]).sum()) for each in own)


def _idf1(poses: PoseTable, truth: PoseTruthTable, frame: Array, found: Correspondence, gate: float) -> float:
    """2 IDTP / (places of persons + poses), with the assignment of numbers to persons that has most IDTP.

    Several poses of one number in a frame, of several cameras for example, are one place that is right.
    """
    rows = np.flatnonzero(found.counts)
    number, column = np.unique(poses.person[rows], return_inverse=True)
    away = np.linalg.norm(poses.pose[rows, None, :2] - truth.pose[frame[rows], :, :2], axis=2)
    near = (away <= gate) & found.needed[frame[rows]]
    at, pose = np.nonzero(near.T)
    right = np.unique(np.column_stack([frame[rows[pose]], at, column[pose]]), axis=0)
    together = np.zeros((found.needed.shape[1], len(number)))
    np.add.at(together, (right[:, 1], right[:, 2]), 1.0)
    total = int(found.needed.sum()) + len(rows)
    return float(2 * together[assigned(together)].sum() / total) if total else np.nan
