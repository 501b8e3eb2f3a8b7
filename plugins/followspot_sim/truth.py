"""Stage `sim.truth`: true positions of the balls of the simulated room, and their visibility."""

from __future__ import annotations

import numpy as np

from followspot import Source
from followspot.tracking import Truth
from followspot_sim.ball_performance import BallPerformance
from followspot_sim.parameters import SimParams
from followspot_sim.visibility import truth_flags, visible_fraction
from followspot_sim.world import setting, world_of


class SimTruth(BallPerformance):
    """Give the ground truth of each frame; the parameters must equal those of the cameras."""

    class Params(SimParams):
        """The performance."""

    params: Params

    def setup(self) -> None:
        """Prepare the performance. Raises InputError for an unknown target."""
        self._world = world_of(setting(self.params, self.room))
        self._radii = np.array([t.radius for t in self.room.targets.values()])
        self._cameras = tuple(self.room.cameras.values())

    def process(self) -> Source[Truth]:
        """Centres of all shown targets, with their visibility in the cameras of the room."""
        for frame in self.frames():
            yield self.at(frame, self.truth(frame))

    def truth(self, frame: int) -> Truth:
        """The truth of one frame."""
        scene = self._world.scene(frame)
        visible = visible_fraction(self._cameras, scene, self._radii)
        shown = ~np.isnan(scene.balls[:, 0])
        hidden, trackable, pair = (column[shown] for column in truth_flags(visible, self._cameras))
        return Truth(
            objects=tuple(name for name, there in zip(self.room.targets, shown, strict=True) if there),
            xyz=scene.balls[shown],
            hidden=hidden,
            trackable=trackable,
            pair=pair,
        )
