"""A V4L2 device that a test stands in for, and what a source takes from it."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import islice
from typing import Any

import cv2
import numpy as np
from tests.plugins.cameras import v4l2_kernel
from tests.plugins.cameras.recordings import context, picture

from followspot.tracking import Frame
from followspot_cameras.v4l2.stage import Device

GRAY = picture(9)[..., 0]
YUYV = np.stack([GRAY, np.full_like(GRAY, 128)], axis=-1).tobytes()
JPEG = cv2.imencode(".jpg", picture(9))[1].tobytes()


class Taken:
    """What a device gives until its camera is gone for good."""

    def __init__(
        self, camera: v4l2_kernel.Camera, kind: str = "color", count: int = 99, **params: Any
    ) -> None:
        self.lost: Counter[str] = Counter()
        self.warnings: list[str] = []
        self.camera = camera
        base = context(kind, warn=self._warned)
        self.device = Device(replace(base, lost=lambda kind, n: self.lost.update({kind: n})), **params)
        self.device.kernel = camera  # type: ignore[misc]
        self.frames: list[Frame] = list(islice(self.device.process(), count))

    def _warned(self, text: str) -> None:
        self.warnings.append(text)
        if not self.camera.steps:
            self.device.close()

    @property
    def losses(self) -> dict[str, int]:
        return {kind: number for kind, number in self.lost.items() if number}
