"""People whose tracks were deleted: a new person who is found near soon afterwards gets the same number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot.assignment import assigned
from followspot.frame_times import NANOSECOND
from followspot_persons.associate.body_model import BodyModel, S
from followspot_persons.associate.colors.torso_colors import log_ratios
from followspot_persons.associate.colors.track_colors import unknown_colors
from followspot_persons.associate.motion import step
from followspot_persons.associate.rows import Rows

PLACE_SIGMA = 0.5
"""Sigma of the place where a track was deleted, per axis, m: it had lost its person before."""
SPEED_SIGMA, SPEED_MEMORY = np.array(1.0), np.array(1.0)
"""Sigma of the velocity of people, m/s, and the time in which it fades, s."""
NEW_PEOPLE = 0.015
"""Density of new people during the time of recall, 1/m^2: one in a room of 8 x 8 m."""


@dataclass(frozen=True, eq=False)
class LostPeople(Rows):
    """number: (L,) of the person; xy: (L, 2) m, where its track was deleted; velocity: (L, 2) m/s; time: (L,)
    of the deletion, ns; colors: (L, C, BINS) of the torso, as in `LifeCycles`.
    """

    number: Array
    xy: Array
    velocity: Array
    time: Array
    colors: Array

    @classmethod
    def none(cls, cameras: int) -> LostPeople:
        """The table without people."""
        nothing = np.zeros(0, int)
        return cls(nothing, np.zeros((0, 2)), np.zeros((0, 2)), nothing, unknown_colors(0, cameras))


def lost(model: BodyModel[S], bodies: S, number: Array, time: int, colors: Array) -> LostPeople:
    """The people of tracks that are deleted at a time, ns."""
    xy = model.middle(bodies)[:, :2]
    velocity = model.middle(model.shifted(bodies, 1.0))[:, :2] - xy
    return LostPeople(number, xy, velocity, np.full(len(number), time), colors)


def found_again(people: LostPeople, xy: Array, colors: Array, time: int) -> tuple[Array, Array]:
    """Rows of lost people and of the new people that they probably are, (K,) each.

    A lost person walks on as people do (`followspot_persons.associate.motion`), and the assignment of largest
    log-likelihood ratio against new people decides. xy: (N, 2) m, places of the new people; colors:
    (N, C, BINS); time: ns.
    """
    if not (len(people) and len(xy)):
        return np.zeros(0, int), np.zeros(0, int)
    seconds = (time - people.time) * NANOSECOND
    motion = step(seconds, SPEED_SIGMA, SPEED_MEMORY)
    squared = np.square(people.xy + motion.reach[:, None] * people.velocity - xy[:, None]).sum(axis=-1)
    variance = PLACE_SIGMA**2 + motion.position
    ratio = -squared / (2 * variance) - np.log(2 * np.pi * variance * NEW_PEOPLE)
    lost_rows, new_rows = assigned((ratio + log_ratios(colors[:, None], people.colors).sum(axis=-1)).T)
    return lost_rows, new_rows
