"""A detector that is none, to see what boxes are worth."""

from __future__ import annotations

from followspot import Stage
from followspot.people import Boxes
from followspot.tracking import Frame


class Blind(Stage):
    """See nobody and say nothing."""

    per_camera = True

    def process(self, frame: Frame) -> Boxes | None:
        return None
