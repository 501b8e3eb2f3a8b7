"""Stage `sim.posed_truth`: true positions and orientations of the balls of the simulated room."""

from __future__ import annotations

import numpy as np

from followspot import Source
from followspot.inertial import PosedTruth
from followspot_sim.ball_performance import BallPerformance
from followspot_sim.imu.parameters import PropParams
from followspot_sim.imu.turning import Turning
from followspot_sim.truth import SimTruth


class PosedSimTruth(BallPerformance):
    """Give the ground truth of each frame; the parameters must equal those of cameras and sensors."""

    class Params(PropParams):
        """The performance, and how its balls turn."""

    params: Params

    def setup(self) -> None:
        """Prepare the performance. Raises InputError for an unknown target."""
        own = self.params.model_dump(exclude={"turn_rate"})
        self._places = SimTruth(self.context, **own)
        self._places.setup()
        self._turning = Turning(self.params.seed, len(self.room.targets), self.params.turn_rate)

    def process(self) -> Source[PosedTruth]:
        """As `sim.truth`, with orientations."""
        for frame in self.frames():
            yield self.at(frame, self.truth(frame))

    def truth(self, frame: int) -> PosedTruth:
        """The truth of one frame."""
        places, time = self._places.truth(frame), np.array([frame / self.params.fps])
        balls = [list(self.room.targets).index(name) for name in places.objects]
        turned = [self._turning.at(ball, time)[0] for ball in balls]
        return PosedTruth(
            places.objects,
            places.xyz,
            places.hidden,
            places.trackable,
            places.pair,
            np.array(turned).reshape(-1, 4),
        )
