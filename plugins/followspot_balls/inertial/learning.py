"""Frames before the heading of a target's sensor is known: the search begins, goes on, and finds it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot.rotation import from_rotation_vector, multiply, turned
from followspot_balls.inertial.beginning import begun, less_sure, turned_away
from followspot_balls.inertial.checkpoint import CONTRADICTIONS, GATE, Checkpoint, Frame
from followspot_balls.inertial.heading import (
    HeadingSearch,
    Steps,
    search_begun,
    search_carried,
    search_coasted,
    search_corrected,
)
from followspot_balls.inertial.history import Rows
from followspot_balls.inertial.sensor_errors import SensorErrors

PROVISIONAL = np.radians(15.0)
"""Sigma of the heading at which navigation begins, while the search goes on."""
LEARNT = np.radians(5.0)
"""Sigma at which the search ends. Navigation alone can mistake its first errors of inclination and bias for
motion that tells the heading; the search cannot."""
APART = 2.0
"""Sigmas of the search by which the navigation's heading may differ then."""


def search_from(frame: Frame, rows: Rows, maximum_gap: float, errors: SensorErrors) -> HeadingSearch | None:
    """The search that begins in a frame, if position and orientation are known.

    rows: readings with orientations, (N, 11), up to the frame; maximum_gap: s.
    """
    if frame.measured is None or not len(rows.time):
        return None
    read, last = int(rows.time[-1]), rows.values[-1]
    if (frame.time - read) * NANOSECOND > maximum_gap:
        return None
    force = complex(_horizontal(rows.values[-1:])[0])
    return search_begun(read, *frame.measured, force, float(last[10]), errors)


def searched(
    search: HeadingSearch, frame: Frame, rows: Rows, maximum_gap: float, errors: SensorErrors
) -> HeadingSearch | None:
    """The search after a frame; None if the positions contradict it.

    rows: readings with orientations, (N, 11), since the search's; maximum_gap: s.
    """
    search = _carried(search, rows, maximum_gap, errors)
    if (frame.time - search.read) * NANOSECOND > maximum_gap:
        search = search_coasted(search, frame.time)
    if frame.measured is None:
        return search._replace(rejected=0)
    search = search_corrected(search, frame.time, *frame.measured, GATE)
    return search if search.rejected < CONTRADICTIONS else None


def navigated(found: Checkpoint, search: HeadingSearch, rows: Rows, errors: SensorErrors) -> Checkpoint:
    """A checkpoint with the search, whose heading begins a navigation, or is compared with that of one.

    rows: readings with orientations, (N, 11).
    """
    unready = search.sigma >= (LEARNT if found.nav else PROVISIONAL)
    if unready or found.frame.measured is None or not len(rows.time) or rows.time[-1] != search.read:
        return found._replace(search=search)
    last, rest = rows.values[-1], search if search.sigma >= LEARNT else None
    heading = from_rotation_vector(np.array([0.0, 0.0, search.heading]))
    quaternion = multiply(heading, last[6:10])
    if found.nav is not None:
        difference = turned_away(found.nav, quaternion)
        if abs(difference) <= APART * search.sigma:
            return found._replace(nav=less_sure(found.nav, difference), search=rest)
    sigma = np.array([last[10], last[10], search.sigma])
    nav = begun(quaternion, sigma, *found.frame.measured, errors)
    return Checkpoint(found.frame, nav, rest, search.read, last[:6])


def _carried(search: HeadingSearch, rows: Rows, maximum_gap: float, errors: SensorErrors) -> HeadingSearch:
    """The search after readings; over gaps between them it coasts."""
    seconds = np.diff(rows.time, prepend=search.read) * NANOSECOND
    force, turn_rate = _horizontal(rows.values), np.linalg.norm(rows.values[:, :3], axis=1)
    for before, after in pairwise([-1, *np.flatnonzero(seconds > maximum_gap), len(seconds)]):
        if before >= 0:
            search = search_coasted(search, int(rows.time[before]))._replace(force=complex(force[before]))
        if before + 1 < after:
            part, inclination = slice(before + 1, after), float(rows.values[after - 1, 10])
            steps = Steps(int(rows.time[after - 1]), seconds[part], force[part], turn_rate[part], inclination)
            search = search_carried(search, steps, errors)
    return search


def _horizontal(values: Array) -> Array:
    """Specific forces in the axes of the orientations, (N,) complex. values: (N, 11)."""
    force = turned(values[:, 6:10], values[:, 3:6])
    return np.asarray(force[:, 0] + 1j * force[:, 1])
