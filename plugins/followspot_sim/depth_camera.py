"""Stage `sim.depth_camera`: one depth camera of the simulated room."""

from __future__ import annotations

from typing import ClassVar

from followspot import Source
from followspot.tracking import DepthImage
from followspot_sim.ball_performance import BallPerformance
from followspot_sim.parameters import DepthCameraParams
from followspot_sim.rendering.depth_picture import DepthPicture


class SimDepthCamera(BallPerformance):
    """Render the simulated room as this depth camera sees it, frame by frame.

    The scene is that of `sim.camera`: cameras of both kinds and equal parameters see one performance. With
    `realtime` frames come no earlier than their time; none is skipped.
    """

    per_camera: ClassVar[bool] = True

    class Params(DepthCameraParams):
        """The performance, and the errors of this camera."""

    params: Params

    def setup(self) -> None:
        """Prepare the empty room and the noise. Raises InputError for an unknown target."""
        self._picture = DepthPicture(self.params, self.room, self.camera)

    def process(self) -> Source[DepthImage]:
        """Depth images at the middle of their exposure: frame k at k / fps seconds, by the camera's clock."""
        for frame in self.frames():
            depth = self.context.loan(self._picture.shape, "f4")
            self._picture.render(frame, depth)
            yield self.at(frame, DepthImage(camera=self.camera.name, depth=depth))
