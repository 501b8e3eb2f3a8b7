"""Stage `sim.person_points`: the joints that a network would find in pictures of the simulated people."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from followspot import Array, Source
from followspot.geometry import undistort
from followspot.people import Boxes
from followspot.points import Points2D
from followspot_sim.actor.exchanged_sides import Exchanges
from followspot_sim.actor.landmarks import NAMES, landmarks
from followspot_sim.actor.network import Finding, NetworkParams, found_in
from followspot_sim.actor.scene import Play, stage_of
from followspot_sim.performance import Performance


@dataclass(frozen=True)
class Outputs:
    """Joints with the number of their person in the picture, and boxes of whole bodies."""

    points: Points2D
    boxes: Boxes


class PersonPoints(Performance):
    """Give the joints and boxes of simulated people as a pose network would find them, without pictures.

    Joints have noise and gaps, and some have gross errors. People hide each other, are missed at random, and
    false persons appear. Every instance computes the same performance as `sim.person_camera` and
    `sim.pose_truth`.
    """

    per_camera: ClassVar[bool] = True

    class Params(NetworkParams):
        """The performance, and the mistakes of a network."""

    params: Params

    def setup(self) -> None:
        """Prepare the performance."""
        self._stage = stage_of(self.params)
        seed = (self.params.seed, zlib.crc32(self.camera.name.encode()))
        self._exchanges = Exchanges(self.params.exchange_share, self.params.exchange_time, seed)

    def process(self) -> Source[Outputs]:
        """Points and boxes of each picture, frame k at k / fps seconds."""
        for frame in self.frames():
            found = self.found(frame)
            points, boxes = self.points(found), self.boxes(found)
            yield Outputs(self.at(frame, points), self.at(frame, boxes))

    def found(self, frame: int) -> Finding:
        """The joints and boxes that are found in one picture."""
        late = self.params.late_by
        play = self._stage.at(frame / self.params.fps + late) if late else self._stage.play(frame)
        people = zip(self._stage.cast, play.stances, play.surfaces, strict=True)
        joints = [landmarks(actor.body, stance, surface) for actor, stance, surface in people]
        names = self._exchanges.names(frame / self.params.fps, self.facing(play))
        rng = np.random.default_rng([*self._exchanges.seed, frame])
        return found_in(self.camera, np.reshape(joints, (-1, 17, 3)), play.heights, names, self.params, rng)

    def facing(self, play: Play) -> Array:
        """Cosine between where each chest points and where the camera is, (P,)."""
        stances = np.array([(one.x, one.y, one.heading) for one in play.stances]).reshape(-1, 3)
        toward = self.camera.center[:2] - stances[:, :2]
        return np.asarray(np.cos(np.arctan2(toward[:, 1], toward[:, 0]) - stances[:, 2]))

    def points(self, found: Finding) -> Points2D:
        """The joints as a message."""
        instance, label = np.nonzero(np.isfinite(found.pixel[..., 0]))
        pixel = found.pixel[instance, label]
        return Points2D(
            camera=self.camera.name,
            labels=NAMES,
            label=label.astype(np.int32),
            instance=instance.astype(np.int32),
            pixel=pixel,
            xy=undistort(self.camera, pixel),
            score=found.score[instance, label],
        )

    def boxes(self, found: Finding) -> Boxes:
        """The boxes as a message."""
        none = np.zeros((len(found.box), 0))
        return Boxes(self.camera.name, found.box, found.score.mean(axis=1), none, none)
