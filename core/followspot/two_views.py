"""A warning for stages that triangulate if their cameras do not see the room from two places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from followspot.errors import Mistake
from followspot.room import Camera

_SAME = 1e-6
"""Distance up to which two cameras count as at one place, m; in an uncalibrated room all are at one."""
_MOST_NAMED = 3


def check_two_views(cameras: Sequence[Camera], need: str) -> Iterator[Mistake]:
    """A warning for `Stage.check_room` if these cameras do not see the room from two places.

    need: beginning of the text, for example "a pair needs blobs of". Without cameras there is no warning: the
    messages may come from a source that serves no camera and sends for several.
    """
    if not cameras:
        return
    if len(cameras) == 1:
        text = f"{need} two cameras, and only camera {cameras[0].name} sends any"
        yield Mistake(None, text, "add a calibrated camera")
    elif np.ptp([camera.center for camera in cameras], axis=0).max() <= _SAME:
        names = [camera.name for camera in cameras]
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        text = (
            f"{need} two cameras at different places, and {', '.join(names[:_MOST_NAMED])}{more} stand at one"
        )
        yield Mistake(None, text, "followspot calibrate wand, or board, finds the places of the cameras")
