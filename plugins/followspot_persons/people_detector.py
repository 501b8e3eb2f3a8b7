"""OpenCV's detector of whole people (Dalal & Triggs 2005), an alternative to that of upper bodies."""

from __future__ import annotations

import cv2
import numpy as np

from followspot import Array, Field, Stage, StageParams
from followspot.people import Boxes
from followspot.tracking import Frame
from followspot_persons.panorama import full_turn

WINDOW = (64, 128)
"""Of the detector, px."""
UPPER = np.array([18.0, 14.0, 46.0, 56.0])
"""Where the window holds the upper body of a person who stands in it, px."""
STRIDE = (8, 8)
FINAL = 1.0
"""Number of windows that a person must be found in, beside the first."""


class PeopleDetector(Stage):
    """Find upright people who are seen from head to foot; it knows nothing of where they look."""

    per_camera = True

    class Params(StageParams):
        every: int = Field(
            1, ge=1, description="search one frame of so many; raising it saves time", unit="1"
        )
        threshold: float = Field(
            0.3,
            ge=0,
            description="least score; raising it finds fewer people, and less that is none",
            unit="1",
        )
        scale: float = Field(
            1.0,
            gt=0,
            le=8,
            description="enlargement of the picture; above 1 smaller people are found",
            unit="1",
        )
        step: float = Field(1.05, ge=1.01, le=2, description="ratio of sizes that are searched", unit="1")

    params: Params

    def setup(self) -> None:
        """Load the weights that OpenCV brings."""
        self.hog = people_hog()
        self.turn = float(self.camera.size[0]) if full_turn(self.camera) else 0.0

    def process(self, frame: Frame) -> Boxes | None:
        p = self.params
        if max(frame.header.seq, 0) % p.every:
            return None
        place, score = self.people(frame.pixels)
        corner, size = place[:, :2], place[:, 2:] / np.array(WINDOW)
        box = np.tile(corner, 2) + UPPER * np.tile(size, 2)
        once = box[:, 0] < self.turn if self.turn else np.ones(len(box), bool)
        unknown = np.empty((int(once.sum()), 0))
        return Boxes(
            camera=frame.camera, box=box[once], score=score[once] - p.threshold, torso=unknown, head=unknown
        )

    def people(self, pixels: Array) -> tuple[Array, Array]:
        """Windows x, y, width, height of people, (N, 4) px of the picture, and their scores."""
        p = self.params
        if pixels.shape[0] * p.scale < WINDOW[1] + 1 or pixels.shape[1] * p.scale < WINDOW[0] + 1:
            return np.empty((0, 4)), np.empty(0)
        if self.turn:
            width = min(pixels.shape[1], pixels.shape[0] // 2)  # no window is wider
            pixels = np.asarray(cv2.copyMakeBorder(pixels, 0, 0, 0, width, cv2.BORDER_WRAP))
        if p.scale != 1:
            pixels = np.asarray(cv2.resize(pixels, None, fx=p.scale, fy=p.scale))
        places, score = self.hog.detectMultiScale(pixels, p.threshold, STRIDE, (0, 0), p.step, FINAL)
        return np.reshape(places, (-1, 4)).astype(float) / p.scale, np.ravel(score).astype(float)


def people_hog() -> cv2.HOGDescriptor:
    """The detector with its weights."""
    hog = cv2.HOGDescriptor()
    hog.setSVMDetector(np.asarray(cv2.HOGDescriptor.getDefaultPeopleDetector(), np.float32))
    return hog
