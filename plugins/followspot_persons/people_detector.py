"""OpenCV's detector of whole people (Dalal & Triggs 2005), an alternative to that of upper bodies."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array, Field, Stage, StageParams
from followspot.people import Boxes
from followspot.tracking import Frame
from followspot_persons.panorama import turn_of

WINDOW = (64, 128)
"""Window of the detector, px."""
UPPER = np.array([18.0, 14.0, 46.0, 56.0])
"""Position of the upper body of a standing person in the window, px."""
STRIDE = (8, 8)
FINAL = 1.0
"""Number of windows that a person must be found in, beside the first."""


class PeopleDetector(Stage):
    """Find upright people that are visible from head to foot, without headings."""

    per_camera = True

    class Params(StageParams):
        frame_interval: int = Field(
            1, ge=1, unit="frames", description="one frame in so many is searched; raising it saves time"
        )
        minimum_score: float = Field(
            0.3,
            ge=0,
            unit="1",
            description="smallest score; raising it finds fewer people, and fewer false ones",
        )
        picture_scale: float = Field(
            1.0,
            gt=0,
            le=8,
            unit="1",
            description="enlargement of the picture; raising it finds smaller people, slower",
        )
        scale_step: float = Field(
            1.05,
            ge=1.01,
            le=2,
            unit="1",
            description="ratio of successive search sizes; raising it saves time",
        )

    params: Params

    def setup(self) -> None:
        """Load the weights that OpenCV brings."""
        self.hog = people_hog()
        self.turn = float(turn_of(self.camera))

    def process(self, frame: Frame) -> Boxes | None:
        p = self.params
        if max(frame.header.seq, 0) % p.frame_interval:
            return None
        place, score = self.people(frame.pixels)
        corner, size = place[:, :2], place[:, 2:] / np.array(WINDOW)
        box = np.tile(corner, 2) + UPPER * np.tile(size, 2)
        once = box[:, 0] < self.turn if self.turn else np.ones(len(box), bool)
        unknown = np.empty((int(once.sum()), 0))
        return Boxes(
            camera=frame.camera,
            box=box[once],
            score=score[once] - p.minimum_score,
            torso=unknown,
            head=unknown,
        )

    def people(self, pixels: Array) -> tuple[Array, Array]:
        """Windows x, y, width, height of people, (N, 4) px of the picture, and their scores."""
        p = self.params
        if (
            pixels.shape[0] * p.picture_scale < WINDOW[1] + 1
            or pixels.shape[1] * p.picture_scale < WINDOW[0] + 1
        ):
            return np.empty((0, 4)), np.empty(0)
        if self.turn:
            width = min(pixels.shape[1], pixels.shape[0] // 2)  # no window is wider
            pixels = np.asarray(cv2.copyMakeBorder(pixels, 0, 0, 0, width, cv2.BORDER_WRAP))
        if p.picture_scale != 1:
            pixels = np.asarray(cv2.resize(pixels, None, fx=p.picture_scale, fy=p.picture_scale))
        places, score = self.hog.detectMultiScale(
            pixels, p.minimum_score, STRIDE, (0, 0), p.scale_step, FINAL
        )
        return np.reshape(places, (-1, 4)).astype(float) / p.picture_scale, np.ravel(score).astype(float)


def people_hog() -> cv2.HOGDescriptor:
    """The detector with its weights."""
    hog = cv2.HOGDescriptor()
    hog.setSVMDetector(np.asarray(cv2.HOGDescriptor.getDefaultPeopleDetector(), np.float32))
    return hog
