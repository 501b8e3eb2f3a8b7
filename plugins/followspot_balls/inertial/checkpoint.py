"""What is known of one target after a frame."""

from __future__ import annotations

from typing import NamedTuple

from followspot import Array
from followspot_balls.inertial.heading import HeadingSearch
from followspot_balls.inertial.navigation import Navigation

GATE = 6.0
"""Sigmas beyond which a position is no measurement of the target."""
CONTRADICTIONS = 5
"""Such positions in successive frames, after which the target is there."""


class Frame(NamedTuple):
    """One frame: its capture time, ns, and the measured position (3,) m with covariance (3, 3), or None."""

    time: int
    measured: tuple[Array, Array] | None


class Checkpoint(NamedTuple):
    """The navigation after a frame, or before its heading is known the search for it, if that has begun.

    read: capture time up to which readings are in it, ns; last: (6,) that reading.
    """

    frame: Frame
    nav: Navigation | None
    search: HeadingSearch | None
    read: int
    last: Array
