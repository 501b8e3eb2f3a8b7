"""Confirmation of tracks: a person gets a number, or the number that the person had before it was lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from followspot import Array
from followspot_persons.associate.body_model import BodyModel, S
from followspot_persons.associate.tracks.lost_people import LostPeople, found_again, lost
from followspot_persons.associate.tracks.tracks import Tracks


def confirmed(
    tracks: Tracks[S], model: BodyModel[S], missed: Array, minimum_odds: float, recalled: int
) -> Tracks[S]:
    """The tracks, of which those that are confirmed now have numbers: of lost people, or new ones from 1.

    missed: (M,) bool, of `ExistenceEvidence`; if a confirmed one of these is near, the new track is the same
    person's, and replaces it. minimum_odds: log-odds that confirm a track; recalled: time for which a number
    is remembered, ns; 0 gives new people new numbers always.
    """
    number = tracks.life.number.copy()
    new = np.flatnonzero((number == 0) & (tracks.life.odds >= minimum_odds))
    people = tracks.lost.where(tracks.time - tracks.lost.time <= recalled)
    if not len(new):
        return replace(tracks, lost=people)
    unseen = np.flatnonzero(missed & (number > 0))
    known = people.joined(remembered(tracks, model, unseen)) if recalled else people
    xy = model.middle(tracks.bodies.where(new))[:, :2]
    rows, found = found_again(known, xy, tracks.life.colors[new], tracks.time)
    number[new[found]] = known.number[rows]
    others = np.delete(new, found)
    number[others] = tracks.numbers + 1 + np.arange(len(others))
    replaced = unseen[rows[rows >= len(people)] - len(people)]
    stay = np.delete(np.arange(len(number)), replaced)
    return replace(
        tracks,
        bodies=tracks.bodies.where(stay),
        life=replace(tracks.life, number=number).where(stay),
        numbers=tracks.numbers + len(others),
        lost=people.where(np.delete(np.arange(len(people)), rows[rows < len(people)])),
    )


def remembered(tracks: Tracks[S], model: BodyModel[S], rows: Array) -> LostPeople:
    """The people of these tracks as lost people of this time."""
    life, bodies = tracks.life.where(rows), tracks.bodies.where(rows)
    return lost(model, bodies, life.number, tracks.time, life.colors)
