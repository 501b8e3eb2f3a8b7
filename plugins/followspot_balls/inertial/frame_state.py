"""State of the navigation of one target after a frame."""

from __future__ import annotations

from typing import NamedTuple

from followspot import Array
from followspot_balls.inertial.heading import HeadingSearch
from followspot_balls.inertial.navigation import Navigation

GATE = 6.0
"""Sigmas beyond which a position is rejected as a measurement of the target."""
MAXIMUM_REJECTED = 5
"""Rejected positions in successive frames, after which the navigation begins anew at the position."""


class Frame(NamedTuple):
    """One frame: its capture time, ns, and the measured position (3,) m with covariance (3, 3), or None."""

    time: int
    measured: tuple[Array, Array] | None


class FrameState(NamedTuple):
    """The navigation after a frame, and the search for its heading while that goes on.

    read: capture time of the last reading that it contains, ns; last: (6,) that reading.
    """

    frame: Frame
    nav: Navigation | None
    search: HeadingSearch | None
    read: int
    last: Array
