"""Limits the time for which infrared cameras alone can prolong a track.

Colour cameras tell which target a ball is. If infrared cameras show something for long that no colour camera
shows, it is a reflector, or the ball of another target.
"""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Room, StageParams
from followspot.geometry import Views
from followspot.tracking import MISSING, Candidates, Forecast, Positions
from followspot_balls.scene.distances import squared_distances
from followspot_balls.scene.targets import target_radii


class ColorlessParams(StageParams):
    """How long infrared cameras alone may prolong a track."""

    colorless_time: float = Field(
        1.0,
        ge=0,
        unit="s",
        description="longest time for which a target keeps its positions while a colour camera has them in "
        "its picture and none shows the target there; 0: without limit; raising it keeps targets longer, "
        "also wrong ones",
    )


class Colorless:
    """Time since a colour camera showed each target of a room."""

    def __init__(self, room: Room, params: ColorlessParams) -> None:
        self.limit = params.colorless_time
        color = [c for c in room.cameras.values() if c.kind == "color"]
        depth = any(c.kind == "depth" for c in room.cameras.values())
        self.applies = bool(color) and not depth and self.limit > 0
        self.color = Views(color)
        self.radius2 = np.square(target_radii(room))
        self.since = np.zeros(len(self.radius2))
        """(T,) s."""

    def bounded(self, positions: Positions, candidates: Candidates, forecast: Forecast | None) -> Positions:
        """The positions, without those of targets that no colour camera has shown for too long.

        A position of a missing target is also left out if it rests on one pair of infrared cameras: the pair
        may show the same reflector that ended the track. If the room has depth cameras, all positions remain,
        because depth tells a ball without its colour.
        """
        target = positions.target
        if not self.applies or forecast is None or not len(target):
            return positions
        shown = self.shown(positions, candidates)
        too_long = self.unshown_too_long(target, shown, positions.xyz, forecast.period)
        if np.count_nonzero(shown) == shown.size:
            return positions
        if len(forecast.state):  # the first forecast knows no targets
            too_long |= ~shown & (positions.support < 2) & (forecast.state[target] == MISSING)
        return positions.where(~too_long) if too_long.any() else positions

    def unshown_too_long(self, target: Array, shown: Array, xyz: Array, period: float) -> Array:
        """Which targets (M,) no colour camera has shown for too long, one frame later: (M,) bool.

        shown: (M,) bool, whether a colour camera shows them in this frame; xyz: (M, 3) m, their positions;
        period: s.
        """
        unseen = ~shown
        if not np.count_nonzero(unseen):
            self.since[target] = 0.0
            return unseen
        unseen[unseen] = self.in_picture(xyz[unseen])
        self.since[target] = np.where(unseen, self.since[target] + period, 0.0)
        return np.asarray(self.since[target] > self.limit)

    def shown(self, positions: Positions, candidates: Candidates) -> Array:
        """Whether a candidate with the colour of its target lies in its ball: (M,) bool."""
        target = positions.target
        inside = squared_distances(positions.xyz, candidates.xyz) < self.radius2.take(target)[:, None]
        inside &= candidates.labelled
        inside &= candidates.targets.take(target, axis=1).T
        return np.asarray(inside.any(axis=1))

    def in_picture(self, xyz: Array) -> Array:
        """Whether positions lie in the picture of a colour camera: (M, 3) m -> (M,) bool."""
        return np.asarray(self.color.in_pictures(xyz).any(axis=0))
