"""Stage `sim.camera`: one camera of the simulated room."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from typing import ClassVar

from followspot import Context, Source, Stage, at
from followspot.tracking import Frame
from followspot_sim.actor.parameters import ActorParams
from followspot_sim.parameters import CameraParams, SimParams
from followspot_sim.picture import Picture


class SimCamera(Stage):
    """Render the simulated room as this camera sees it, frame by frame.

    Every instance computes the same performance, so the pictures are consistent in any placement. With
    `realtime` frames come no earlier than their time; none is skipped.
    """

    per_camera: ClassVar[bool] = True

    class Params(CameraParams):
        """The performance, and the clock of this camera."""

    params: Params

    def setup(self) -> None:
        """Prepare the constant parts of all pictures. Raises InputError for an unknown target."""
        self._picture = Picture(self.params, self.room, self.camera, self.params.clock_offset)

    def length(self) -> int | None:
        """Number of pictures; None if they never end."""
        return self.params.frames or None

    def process(self) -> Source[Frame]:
        """Pictures at the middle of their exposure: frame k at k / fps seconds, by the camera's clock."""
        for frame, time_ns in schedule(self.params, self.context):
            pixels = self.context.loan(self._picture.shape, "u1")
            self._picture.render(frame, pixels)
            yield at(time_ns, Frame(camera=self.camera.name, pixels=pixels), seq=frame)


def schedule(params: SimParams | ActorParams, context: Context) -> Iterator[tuple[int, int]]:
    """Frame numbers with their capture times in ns; with `realtime`, at the pace of the clock."""
    begin = time.monotonic()
    for frame in range(params.frames) if params.frames else itertools.count():
        if params.realtime and not context.pause(max(0.0, begin + frame / params.fps - time.monotonic())):
            return
        yield frame, round(frame * 1e9 / params.fps)
