"""Stage `sim.camera`: one camera of the simulated room."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from followspot import Source
from followspot.tracking import Frame
from followspot_sim.ball_performance import BallPerformance
from followspot_sim.parameters import CameraParams
from followspot_sim.rendering.picture import Picture


class SimCamera(BallPerformance):
    """Render the simulated room as this camera sees it, frame by frame.

    Every instance computes the same performance, so the pictures are consistent in any placement. With
    `realtime` frames come no earlier than their time; none is skipped. A camera of `kind: depth` gets
    `sim.depth_camera`, which renders the depth of the same scene and takes these parameters, too.
    """

    per_camera: ClassVar[bool] = True
    by_kind: ClassVar[Mapping[str, str]] = {"depth": "sim.depth_camera"}

    class Params(CameraParams):
        """The performance, and the clock of this camera."""

    params: Params

    def setup(self) -> None:
        """Prepare the constant parts of all pictures. Raises InputError for an unknown target."""
        self._picture = Picture(self.params, self.room, self.camera, self.params.clock_offset)

    def process(self) -> Source[Frame]:
        """Pictures at the middle of their exposure: frame k at k / fps seconds, by the camera's clock."""
        for frame in self.frames():
            pixels = self.context.loan(self._picture.shape, "u1")
            self._picture.render(frame, pixels)
            yield self.at(frame, Frame(camera=self.camera.name, pixels=pixels))
