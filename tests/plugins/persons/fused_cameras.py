"""A fusion of two cameras, which is told poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from tests.plugins.persons.drawn import SECOND, perspective

from followspot import Room
from followspot.context import Context
from followspot.messages import Header, stamped
from followspot.people import Poses
from followspot.tracking import TRACKED
from followspot_persons.fusion import Fusion

RATE = 15


class Cameras:
    """A fusion of cameras `a` and `b`, both at the origin, that is told poses 15 times a second."""

    def __init__(self, **params: object) -> None:
        cameras = {name: perspective(name) for name in ("a", "b")}
        self.stage = Fusion(Context(room=Room(cameras=cameras)), **params)
        self.stage.setup()
        self.frame = 0

    def tell(self, *people: tuple[str, int, float, float]) -> Poses:
        """The fused poses of a picture; each of `people`: camera, number there, x and y in m."""
        time = Header("fuse", self.frame, self.frame * SECOND // RATE)
        self.frame += 1
        told = [
            stamped(camera_poses(name, [p[1:] for p in people if p[0] == name]), time) for name in ("a", "b")
        ]
        return self.stage.process(tuple(told))


def camera_poses(name, people):
    """A camera's poses. people: number, x, y."""
    rows = np.array(people, float).reshape(-1, 3)
    count = len(rows)
    return replace(
        Poses.empty(),
        camera=name,
        person=rows[:, 0].astype(np.int32),
        state=np.full(count, TRACKED, np.uint8),
        xy=rows[:, 1:],
        height=np.full(count, 1.7),
        heading=np.zeros(count),
        pan=np.zeros(count),
        tilt=np.zeros(count),
        sigma=np.full((count, 6), 0.1),
        confidence=np.full(count, 0.6),
    )
