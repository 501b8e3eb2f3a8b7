"""Stages for tests: pictures of one camera that are passed on. Loaded with --plugin."""

from __future__ import annotations

import numpy as np

from followspot import Source, Stage, at
from followspot.tracking import Frame


class Camera(Stage):
    """Gives three pictures that are too large for a datagram."""

    def process(self) -> Source[Frame]:
        for number in range(3):
            yield at(number * 10_000_000, Frame("cam0", np.full((100, 100, 3), number, dtype="u1")))


class Gray(Stage):
    """Keeps one channel."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, frame.pixels[..., :1].copy())


class Keep(Stage):
    """Takes pictures and forgets them."""

    def process(self, frame: Frame) -> None:
        return
