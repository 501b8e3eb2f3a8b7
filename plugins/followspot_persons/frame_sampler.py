"""Samples the pictures of a camera for the slow instance, at the rate that it can take (section 5)."""

from __future__ import annotations

from followspot import Stage
from followspot.tracking import Frame


class FrameSampler(Stage):
    """Give several slow stages the same picture of a camera: the newest when they have time for one.

    This needs `policy: latest` on its input and `depth: 1` on its outputs: the other pictures are dropped
    before any work is done on them. A recorded camera waits instead.
    """

    per_camera = True

    def process(self, frame: Frame) -> Frame:
        return frame
