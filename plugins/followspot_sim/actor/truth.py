"""Stage `sim.pose_truth`: how the people of the simulated room really stand, and how much cameras see."""

from __future__ import annotations

import numpy as np

from followspot import Array, Field, Source
from followspot.people import PoseTruth
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.scene import Play, stage_of
from followspot_sim.actor.visibility import VisibilityOfActors
from followspot_sim.performance import Performance


class PoseTruthOfActors(Performance):
    """Give the true poses of each frame; the parameters must equal those of the cameras."""

    class Params(ActorParams):
        """The people and the room."""

        visibility: bool = Field(
            True,
            description="whether to compute how much of each person the cameras see, which takes time; if "
            "not, every person counts as visible",
        )

    params: Params

    def setup(self) -> None:
        """Prepare the performance and the visibility for each camera of the room."""
        self._stage = stage_of(self.params)
        cameras = self.room.cameras.values() if self.params.visibility else ()
        self._visibilities = [VisibilityOfActors(self.params, camera) for camera in cameras]

    def process(self) -> Source[PoseTruth]:
        """The poses of all people, with the visible share in the camera that sees most."""
        for frame in self.frames():
            yield self.at(frame, self.truth(frame))

    def truth(self, frame: int) -> PoseTruth:
        """The truth of one frame."""
        play = self._stage.play(frame)
        people = len(play.stances)
        pose = np.array([(s.x, s.y, s.heading, s.pan, s.tilt) for s in play.stances]).reshape(-1, 5)
        return PoseTruth(
            person=np.arange(1, people + 1, dtype=np.int32),
            xy=pose[:, :2],
            height=play.heights,
            heading=pose[:, 2],
            pan=pose[:, 3],
            tilt=pose[:, 4],
            visible=self._visible(play),
        )

    def _visible(self, play: Play) -> Array:
        """Visible share of each person in the camera that sees most."""
        if not self.params.visibility:
            return np.ones(len(play.stances))
        shares = [one.visible(play) for one in self._visibilities]
        return np.asarray(np.max(shares, axis=0)) if shares else np.zeros(len(play.stances))
