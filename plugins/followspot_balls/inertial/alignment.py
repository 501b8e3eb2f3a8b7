"""Alignment of an inertial sensor: frames in which its heading is searched, until a navigation can begin."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot.rotation import from_rotation_vector, multiply, turned
from followspot_balls.inertial.frame_state import GATE, MAXIMUM_REJECTED, Frame, FrameState
from followspot_balls.inertial.heading import (
    HeadingSearch,
    Steps,
    search_coasted,
    search_corrected,
    search_initiated,
    search_propagated,
)
from followspot_balls.inertial.history import Rows
from followspot_balls.inertial.initiation import heading_difference, initiated, with_heading_error
from followspot_balls.inertial.sensor_errors import SensorErrors

PROVISIONAL_SIGMA = np.radians(15.0)
"""Sigma of the heading at which navigation begins, while the search goes on."""
ALIGNED_SIGMA = np.radians(5.0)
"""Sigma of the heading at which the search ends. Navigation alone can mistake its first errors of
inclination and bias for motion that tells the heading; the search cannot."""
MAXIMUM_DIFFERENCE = 2.0
"""Sigmas of the search by which the navigation's heading may differ at the end."""


def search_from(frame: Frame, rows: Rows, maximum_gap: float, errors: SensorErrors) -> HeadingSearch | None:
    """The search that begins with a frame, if position and orientation are known.

    rows: readings with orientations, (N, 11), up to the frame; maximum_gap: s.
    """
    if frame.measured is None or not len(rows.time):
        return None
    read, last = int(rows.time[-1]), rows.values[-1]
    if (frame.time - read) * NANOSECOND > maximum_gap:
        return None
    force = complex(_horizontal(rows.values[-1:])[0])
    return search_initiated(read, *frame.measured, force, float(last[10]), errors)


def searched(
    search: HeadingSearch, frame: Frame, rows: Rows, maximum_gap: float, errors: SensorErrors
) -> HeadingSearch | None:
    """The search after a frame; None if the positions contradict it.

    rows: readings with orientations, (N, 11), since the search's; maximum_gap: s.
    """
    search = _propagated(search, rows, maximum_gap, errors)
    if (frame.time - search.read) * NANOSECOND > maximum_gap:
        search = search_coasted(search, frame.time)
    if frame.measured is None:
        return search._replace(rejected=0)
    search = search_corrected(search, frame.time, *frame.measured, GATE)
    return search if search.rejected < MAXIMUM_REJECTED else None


def with_navigation(found: FrameState, search: HeadingSearch, rows: Rows, errors: SensorErrors) -> FrameState:
    """The state with the search, whose heading begins a navigation, or is compared with that of one.

    rows: readings with orientations, (N, 11).
    """
    unready = search.sigma >= (ALIGNED_SIGMA if found.nav else PROVISIONAL_SIGMA)
    if unready or found.frame.measured is None or not len(rows.time) or rows.time[-1] != search.read:
        return found._replace(search=search)
    last, rest = rows.values[-1], search if search.sigma >= ALIGNED_SIGMA else None
    heading = from_rotation_vector(np.array([0.0, 0.0, search.heading]))
    quaternion = multiply(heading, last[6:10])
    if found.nav is not None:
        difference = heading_difference(found.nav, quaternion)
        if abs(difference) <= MAXIMUM_DIFFERENCE * search.sigma:
            return found._replace(nav=with_heading_error(found.nav, difference), search=rest)
    sigma = np.array([last[10], last[10], search.sigma])
    nav = initiated(quaternion, sigma, *found.frame.measured, errors)
    return FrameState(found.frame, nav, rest, search.read, last[:6])


def _propagated(search: HeadingSearch, rows: Rows, maximum_gap: float, errors: SensorErrors) -> HeadingSearch:
    """The search after readings; over gaps between them it coasts."""
    seconds = np.diff(rows.time, prepend=search.read) * NANOSECOND
    force, turn_rate = _horizontal(rows.values), np.linalg.norm(rows.values[:, :3], axis=1)
    for before, after in pairwise([-1, *np.flatnonzero(seconds > maximum_gap), len(seconds)]):
        if before >= 0:
            search = search_coasted(search, int(rows.time[before]))._replace(force=complex(force[before]))
        if before + 1 < after:
            part, inclination = slice(before + 1, after), float(rows.values[after - 1, 10])
            steps = Steps(int(rows.time[after - 1]), seconds[part], force[part], turn_rate[part], inclination)
            search = search_propagated(search, steps, errors)
    return search


def _horizontal(values: Array) -> Array:
    """Specific forces in the axes of the orientations, (N,) complex. values: (N, 11)."""
    force = turned(values[:, 6:10], values[:, 3:6])
    return np.asarray(force[:, 0] + 1j * force[:, 1])
