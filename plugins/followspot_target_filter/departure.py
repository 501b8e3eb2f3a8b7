"""Doubts tracks that few candidates, or cameras of one kind, have shown for long: they may be astray."""

from __future__ import annotations

import numpy as np

from followspot.geometry import Views
from followspot.messages import Array
from followspot.room import Room
from followspot.tracking import TRACKED
from followspot_target_filter.life_cycle import LifeCycle, has_position

SEARCH_INTERVAL = 5
"""A doubted target is searched for everywhere in every fifth frame. If it is found elsewhere, the next frame
must confirm this, so that a coincidence in one frame does not count."""
DEPARTURE_RATE = 0.3
"""Rate at which tracks leave their targets while few candidates show them, 1/s."""
DEPARTURE_SIGMA = 0.16
"""Distance of such a track from its target along each axis, m, root mean square."""
MINIMUM_VIEWS = 3
"""Smallest number of cameras with the target in their pictures for which few candidates are a reason for
doubt."""


class DepartureTest:
    """Doubts tracks of targets that several cameras have in their pictures; targets with a mark excepted.

    doubt_frames: number of successive frames in which the positions are not :meth:`agreed`, after which a
    target is doubted; 0: never.
    If no camera sees colours, no target is doubted, because nothing would tell it from other things.
    """

    def __init__(self, room: Room, marked: Array, doubt_frames: int) -> None:
        """marked: (T,) bool, targets with a mark."""
        self.views = Views(room.cameras.values())
        self.marked = marked
        self.colored = np.array([camera.kind == "color" for camera in self.views.cameras], bool)
        self.frames = doubt_frames if self.colored.any() else 0

    def agreed(self, support: Array, confirmed: Array, xyz: Array, least: int) -> Array:
        """Which positions, (M, 3) m, nothing speaks against: (M,) bool.

        Enough candidates show them, and cameras of both kinds do if both have them in their pictures.
        support: (M,) number of candidates; confirmed: (M,) bool, whether both kinds show it; least: enough.
        """
        enough = support >= least
        asked = enough & ~confirmed
        if np.count_nonzero(asked):
            seen = self.views.in_pictures(xyz[asked])
            enough[asked] = seen[self.colored].any(axis=0) != seen[~self.colored].any(axis=0)
        return np.asarray(enough)

    def doubted(self, life: LifeCycle, xyz: Array) -> Array:
        """Targets that are also searched elsewhere in the next frame: (T,) bool. xyz: (T, 3) m."""
        beyond = life.weak - self.frames
        if not self.frames or beyond.max(initial=-1) < 0:
            return np.zeros(len(beyond), bool)
        first = (beyond % SEARCH_INTERVAL == 0) & (life.status == TRACKED)
        again = (beyond % SEARCH_INTERVAL == 1) & has_position(life.status) & (life.streak > 0)
        return self._testable(np.asarray((beyond >= 0) & (first | again)), xyz)

    def widened(self, sigma: Array, life: LifeCycle, xyz: Array, period: float) -> Array:
        """The filter's sigma, (T, 3) m, wider for tracks that may have left their targets. period: s."""
        if not self.frames or not np.count_nonzero(life.weak):
            return sigma
        seconds = self._testable(life.weak > 0, xyz) * life.weak * period
        return np.asarray(np.sqrt(sigma * sigma + departure_variance(seconds)[:, None]))

    def _testable(self, targets: Array, xyz: Array) -> Array:
        """(T,) which of the targets have no mark and lie in the pictures of several cameras."""
        testable = targets & ~self.marked
        if np.count_nonzero(testable):
            testable &= self.views.in_pictures(xyz).sum(axis=0) >= MINIMUM_VIEWS
        return testable


def departure_variance(seconds: Array) -> Array:
    """Variance along each axis, m^2, of where targets are whose tracks may have left them, of any shape.

    The filter assumes independent errors in successive frames, but the cause that leads a track away acts in
    all of them.
    seconds: for which few candidates have shown each.
    """
    return np.asarray(-np.expm1(-DEPARTURE_RATE * seconds) * DEPARTURE_SIGMA**2)
