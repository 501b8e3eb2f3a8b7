"""Stage `sim.person_camera`: one camera of the simulated room with people."""

from __future__ import annotations

from typing import ClassVar

from followspot import Source
from followspot.tracking import Frame
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.actor.picture import ActorPicture
from followspot_sim.performance import Performance


class PersonCamera(Performance):
    """Render people who walk, turn and look around in a furnished room, as this camera sees them.

    Every instance computes the same performance, so the pictures are consistent in any placement. With
    `realtime` frames come no earlier than their time; none is skipped.
    """

    per_camera: ClassVar[bool] = True

    class Params(ActorParams):
        """The people and the room."""

    params: Params

    def setup(self) -> None:
        """Draw the empty room."""
        self._picture = ActorPicture(self.params, self.camera)

    def process(self) -> Source[Frame]:
        """Pictures, frame k at k / fps seconds."""
        for frame in self.frames():
            pixels = self.context.loan(self._picture.shape, "u1")
            self._picture.render(frame, pixels)
            yield self.at(frame, Frame(camera=self.camera.name, pixels=pixels))
