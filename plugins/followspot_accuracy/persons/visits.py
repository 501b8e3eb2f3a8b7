"""Persons that enter, leave and return: delays of detection and deletion, and re-identification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot_accuracy.persons.matching import UNMATCHED, Matches
from followspot_accuracy.persons.tables import PoseTable, PoseTruthTable

SEEN = 0.5
"""Visible share of the upper body from which a person has to be tracked."""
GONE = 0.05
"""Visible share below which a person has left."""


@dataclass(frozen=True)
class Visit:
    """Frames of one stay: from the first in which the person is seen to the first after the person left."""

    start: int
    end: int


@dataclass(frozen=True)
class VisitStatistics:
    """Delays and re-identifications of a person's visits.

    acquire_s: for each visit, from first visibility to the first right position, or its whole length if none
    came; vanish_s: for each that ended, how long the pose stayed; returns, known: number of visits after the
    first tracked one, and how many of them got the same number.
    """

    acquire_s: tuple[float, ...] = ()
    vanish_s: tuple[float, ...] = ()
    returns: int = 0
    known: int = 0


def visits(visible: Array) -> list[Visit]:
    """The visits of a person whose visible share is (F,)."""
    found: list[Visit] = []
    start = -1
    for frame, share in enumerate(visible.tolist()):
        if start < 0 and share >= SEEN:
            start = frame
        elif start >= 0 and share < GONE:
            found.append(Visit(start, frame))
            start = -1
    return found if start < 0 else [*found, Visit(start, len(visible))]


def visit_statistics(poses: PoseTable, truth: PoseTruthTable, matches: Matches, own: int) -> VisitStatistics:
    """Statistics of the visits of the truth's person number `own`."""
    stays = visits(truth.visible[:, own])
    identity = matches.identity[:, own]
    frames = len(truth.time)
    moment = np.append(truth.time, truth.time[-1:] + _interval(truth.time))
    acquire, vanish, known = [], [], []
    last = UNMATCHED
    for number, stay in enumerate(stays):
        right = stay.start + np.flatnonzero(identity[stay.start : stay.end] != UNMATCHED)
        found = right[0] if len(right) else stay.end
        acquire.append(float(moment[found] - moment[stay.start]))
        if len(right):
            if last != UNMATCHED:
                known.append(int(identity[right[0]]) == last)
            last = int(identity[right[-1]])
        if len(right) and stay.end < frames:
            until = stays[number + 1].start if number + 1 < len(stays) else frames
            shown = ghost_frames(poses, matches, own, last, stay.end, until)
            vanish.append(float(moment[shown[-1] + 1] - moment[stay.end]) if len(shown) else 0.0)
    return VisitStatistics(tuple(acquire), tuple(vanish), len(known), sum(known))


def ghost_frames(poses: PoseTable, matches: Matches, own: int, number: int, start: int, end: int) -> Array:
    """Ascending frames from start to end in which the number is reported and is no other person's."""
    frame = matches.frame
    rows = np.flatnonzero((poses.person == number) & (frame >= start) & (frame < end))
    others = np.delete(matches.identity, own, axis=1)
    free = (others[frame[rows]] != number).all(axis=1)
    return np.sort(frame[rows[free]])


def identity_switches(identity: Array) -> Array:
    """(P,) number of times that a person got a new number, or the number of another person.

    Unlike the switches of MOTA (`tracking`), a number counts that was another person's before, even if it is
    the person's first one or the same as before.

    identity: (F, P) numbers, -1 for none.
    """
    persons = identity.shape[1]
    count = np.zeros(persons, int)
    number: list[int] = [UNMATCHED] * persons
    owner: dict[int, int] = {}
    for f, p in np.argwhere(identity != UNMATCHED).tolist():
        found = int(identity[f, p])
        count[p] += number[p] not in (UNMATCHED, found) or owner.get(found, p) != p
        number[p], owner[found] = found, p
    return count


def _interval(time: Array) -> Sequence[float] | float:
    """Usual distance of neighbouring times, s."""
    return float(np.median(np.diff(time))) if len(time) > 1 else 0.0
