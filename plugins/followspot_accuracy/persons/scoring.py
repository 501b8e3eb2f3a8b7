"""Scores per person and in all: errors of the pose, coverage, identity, visits, and false persons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_accuracy.persons.errors import PoseErrors, pose_errors, together
from followspot_accuracy.persons.matching import REACH, UNMATCHED, Matches, match
from followspot_accuracy.persons.tables import PoseTable, PoseTruthTable
from followspot_accuracy.persons.tracking import Area, Tracking, tracking
from followspot_accuracy.persons.visits import SEEN, VisitStatistics, identity_switches, visit_statistics
from followspot_accuracy.statistics import share, statistic

NEAR, WIDE, FLIPPED = 22.5, 45.0, 135.0
"""Errors of the torso's heading up to which it is right, roughly right, and from which it is flipped, deg."""


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation of errors; median and 95th percentile of their size."""

    mean: float
    sigma: float
    median: float
    p95: float


@dataclass(frozen=True)
class Torso:
    """Errors of the chest's heading: median size, deg; shares within 22.5 and 45 deg and over 135 deg."""

    median_deg: float
    within_22: float
    within_45: float
    flipped: float


@dataclass(frozen=True)
class PersonScore:
    """How a person was tracked. A figure is NaN if there was nothing to measure.

    Errors are taken in frames that show at least half of the upper body, of poses up to 1 m away.
    """

    frames: int
    """Frames that show at least half of the upper body."""
    coverage: float
    """Share of them with a pose within 0.5 m of the person."""
    direction_deg: Spread
    distance_m: Spread
    height_cm: Spread
    position_cm: Spread
    """Distance on the floor."""
    torso: Torso
    pan_median_deg: float
    tilt_median_deg: float
    identity_switches: int
    """Number of times that the person got a new number, or the number of another person."""
    acquire_s: tuple[float, ...]
    """For each time the person came: from being half visible to the first pose within 0.5 m."""
    vanish_s: tuple[float, ...]
    """For each time the person left: how long the pose stayed."""
    returns: int
    returns_known: int
    """Returns under the same number."""


@dataclass(frozen=True)
class Surplus:
    """Surplus poses, which match no person."""

    frames: int
    """Frames of the truth."""
    false_rows: int
    """Poses farther than 0.5 m from every person, seen or not."""
    false_share: float
    """Share of frames that have one."""
    duplicate_rows: int
    """Second poses near a matched person."""


@dataclass(frozen=True)
class PersonsScore:
    """Scores by the person's number in the truth, of all persons together, and the surplus."""

    persons: Mapping[str, PersonScore]
    overall: PersonScore
    surplus: Surplus
    tracking: Tracking


def score_persons(poses: PoseTable, truth: PoseTruthTable, area: Area | None = None) -> PersonsScore:
    """Compare poses with the truth. area: x0, y0, x1, y1, m, that the truth covers, for MOTA and IDF1."""
    matches = match(poses, truth)
    errors = list(errors_of(poses, truth, matches).values())
    visited = [visit_statistics(poses, truth, matches, own) for own in range(len(truth.persons))]
    switched = identity_switches(matches.identity)
    seen, covered = truth.visible >= SEEN, matches.identity != UNMATCHED
    each = {
        str(person): _person_score(
            seen[:, own], covered[:, own], errors[own], int(switched[own]), [visited[own]]
        )
        for own, person in enumerate(truth.persons)
    }
    overall = _person_score(seen, covered, together(errors), int(switched.sum()), visited)
    return PersonsScore(each, overall, _surplus(matches), tracking(poses, truth, area))


def errors_of(poses: PoseTable, truth: PoseTruthTable, matches: Matches) -> dict[int, PoseErrors]:
    """Errors of each person's poses in the frames that show at least half of the upper body."""
    found = {}
    for own, person in enumerate(truth.persons):
        frames = np.flatnonzero((truth.visible[:, own] >= SEEN) & (matches.row[:, own] != UNMATCHED))
        rows = matches.row[frames, own]
        found[person] = pose_errors(poses.pose[rows], truth.pose[frames, own], truth.viewpoint)
    return found


def _person_score(
    seen: Array,
    covered: Array,
    errors: PoseErrors,
    switched: int,
    visited: Sequence[VisitStatistics],
) -> PersonScore:
    return PersonScore(
        frames=int(seen.sum()),
        coverage=share(covered & seen, seen),
        direction_deg=_spread(np.degrees(errors.direction)),
        distance_m=_spread(errors.distance),
        height_cm=_spread(100 * errors.height),
        position_cm=_spread(100 * errors.position),
        torso=_torso(np.degrees(np.abs(errors.torso))),
        pan_median_deg=statistic(np.degrees(np.abs(errors.pan)), np.median),
        tilt_median_deg=statistic(np.degrees(np.abs(errors.tilt)), np.median),
        identity_switches=switched,
        acquire_s=tuple(s for one in visited for s in one.acquire_s),
        vanish_s=tuple(s for one in visited for s in one.vanish_s),
        returns=sum(one.returns for one in visited),
        returns_known=sum(one.known for one in visited),
    )


def _spread(values: Array) -> Spread:
    size = np.abs(values)
    return Spread(
        statistic(values, np.mean),
        statistic(values, np.std),
        statistic(size, np.median),
        statistic(size, lambda v: float(np.percentile(v, 95))),
    )


def _torso(size: Array) -> Torso:
    every = np.ones(len(size), bool)
    return Torso(
        statistic(size, np.median),
        share(size <= NEAR, every),
        share(size <= WIDE, every),
        share(size > FLIPPED, every),
    )


def _surplus(matches: Matches) -> Surplus:
    frames = len(matches.row)
    timely = matches.frame != UNMATCHED
    false = timely & (matches.apart > REACH)
    unmatched = ~np.isin(np.arange(len(matches.frame)), matches.row)
    with_false = np.isin(np.arange(frames), matches.frame[false])
    return Surplus(
        frames,
        int(false.sum()),
        share(with_false, np.ones(frames, bool)),
        int((timely & unmatched & (matches.apart <= REACH)).sum()),
    )
