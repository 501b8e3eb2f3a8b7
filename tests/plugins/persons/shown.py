"""The instances of a pose tracker that are shown drawn pictures: the slow one, and the fast one."""

from __future__ import annotations

import numpy as np
from tests.plugins.persons.drawn import (
    BACK,
    SECOND,
    SHIRT,
    boxes_of,
    clothes,
    drawn,
    frame_of,
    gradients_of,
    perspective,
    ready,
)

from followspot.messages import Header, stamped
from followspot.people import Appearances
from followspot_persons.appearance import Appearance
from followspot_persons.body.shape import read_shape
from followspot_persons.color.hsi import hsi
from followspot_persons.pose_tracker import PoseTracker

PERIOD = 0.1
"""Between two pictures of the fast instance, s."""


class SlowInstance:
    """A slow instance that is shown pictures, two a second, and boxes of a perfect detector.

    Standing people sway by some pixels. grounded: of :func:`drawn`.
    """

    def __init__(self, *, sway: int = 2, grounded: bool = False, **params: object) -> None:
        self.sway, self.grounded = sway, grounded
        self.camera = perspective()
        self.stage = ready(Appearance, self.camera, **{"particles": 60, **params})
        self.number = 0

    def see(self, *poses, boxed=None, score=2.0, front=SHIRT, back=BACK):
        """What the stage says of a picture with bodies of these poses."""
        pixels = drawn(self.camera, *poses, front=front, back=back, grounded=self.grounded)
        pixels = np.roll(pixels, self.sway * (self.number % 2), axis=1)
        return self.see_pixels(pixels, boxed=poses if boxed is None else boxed, score=score)

    def see_pixels(self, pixels, *, boxed, score):
        """What the stage says of a picture with these boxes."""
        frame = frame_of(self.camera, pixels, self.number / 2, self.number)
        self.number += 1
        boxes = boxes_of(self.camera, frame, *boxed, score=score)
        return self.stage.process(frame, gradients_of(self.camera, frame), boxes)

    def leave(self, pictures=8):
        """Show an empty room in some pictures; after four of them the stage calls a person absent."""
        for _ in range(pictures):
            told = self.see()
        return told


def numbers(told):
    """The numbers of the people of whom a message tells."""
    return told.person.tolist()


class FastInstance:
    """A fast instance that is shown pictures, ten a second."""

    def __init__(self, **params: object) -> None:
        self.camera = perspective()
        self.stage = ready(PoseTracker, self.camera, **{"particles": 80, **params})
        self.number = 0
        self.told = None

    def tell(self, *poses, front=SHIRT, back=BACK, left=(), stands=(0.0, 0.0)):
        """The slow instance reports people for the next picture; stands: as `contact` of `Appearances`."""
        colors = hsi(clothes(read_shape(), front, back).astype(np.uint8))
        count, time = len(poses), int(self.number * PERIOD * SECOND)
        message = Appearances(
            camera="c",
            person=np.arange(1, count + 1, dtype=np.int32),
            mean=np.tile(colors.astype(float), (count, 1, 1)),
            variance=np.full((count, 45, 3), 0.01),
            evidence=np.ones((count, 45)),
            pose=np.array(poses).reshape(-1, 6),
            stature=np.tile([1.7, 0.03], (count, 1)),
            contact=np.tile(stands, (count, 1)),
            seen=np.full(count, time, np.int64),
            left=np.isin(np.arange(1, count + 1), left).astype(np.uint8),
        )
        self.told = stamped(message, Header("c", self.number, time))

    def see(self, *poses, boxed=(), front=SHIRT, back=BACK):
        """Poses in a picture with these bodies, and boxes of some; no message of the detector for None."""
        pixels = drawn(self.camera, *poses, front=front, back=back)
        frame = frame_of(self.camera, pixels, self.number * PERIOD, self.number)
        self.number += 1
        boxes = None if boxed is None else boxes_of(self.camera, frame, *boxed)
        return self.stage.process(frame, gradients_of(self.camera, frame), self.told, boxes)
