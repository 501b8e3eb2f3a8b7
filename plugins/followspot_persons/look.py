"""The input of the slow instance: one picture whenever the instance has time for it (section 5)."""

from __future__ import annotations

from followspot import Stage
from followspot.tracking import Frame


class Look(Stage):
    """Pass a camera's picture on to several slow stages, so that all of them work on the same one.

    With `policy: latest` on its input and `depth: 1` behind it, the stage drops a live camera's pictures
    before any work was done on them, and passes on the newest.
    """

    per_camera = True

    def process(self, frame: Frame) -> Frame:
        return frame
