"""Tracks of the people of a room: states of their bodies, and the life cycle of each track."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot_persons.associate.body_model import BodyModel, S
from followspot_persons.associate.colors.track_colors import unknown_colors
from followspot_persons.associate.multi_view.views import Views
from followspot_persons.associate.rows import Rows
from followspot_persons.associate.tracks.lost_people import LostPeople


@dataclass(frozen=True, eq=False)
class LifeCycles(Rows):
    """number: (M,) of the person, 0 until it is confirmed; odds: (M,) log-odds of existence; seen: (M,) time
    of the last detection, ns; colors: (M, C, BINS) histograms of the torso in each camera, NaN if unknown.
    """

    number: Array
    odds: Array
    seen: Array
    colors: Array


@dataclass(frozen=True, eq=False)
class Tracks(Generic[S]):
    """M people at a time, ns. bodies: their states; life: their life cycles; numbers: how many persons were
    confirmed so far; unassigned: (C, 2) of each camera, its detections while there were confirmed people, and
    those that were assigned to none of them; lost: people whose tracks were deleted lately.
    """

    bodies: S
    life: LifeCycles
    time: int
    numbers: int
    unassigned: Array
    lost: LostPeople


def no_tracks(model: BodyModel[S], views: Views) -> Tracks[S]:
    """The tracks of a room in which no person is known yet."""
    cameras = len(views.each)
    life = LifeCycles(np.zeros(0, int), np.zeros(0), np.zeros(0, int), unknown_colors(0, cameras))
    return Tracks(model.none(), life, 0, 0, np.zeros((cameras, 2), int), LostPeople.none(cameras))


def predicted(tracks: Tracks[S], model: BodyModel[S], time: int) -> Tracks[S]:
    """The people at a later time, ns."""
    if not len(tracks.bodies) or time <= tracks.time:
        return replace(tracks, time=max(time, tracks.time))
    seconds = (time - tracks.time) * NANOSECOND
    return replace(tracks, bodies=model.predicted(tracks.bodies, seconds), time=time)


def shifted(tracks: Tracks[S], model: BodyModel[S], by: int) -> Tracks[S]:
    """The people where their motion takes them some ns later, or earlier; the time of the tracks stays."""
    return replace(tracks, bodies=model.shifted(tracks.bodies, by * NANOSECOND)) if by else tracks


def reported_at(tracks: Tracks[S], model: BodyModel[S], time: int) -> Tracks[S]:
    """The people at a time, ns, near that of the last exposure, for a report."""
    return shifted(tracks, model, time - tracks.time)
