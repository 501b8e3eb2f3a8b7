"""Whether cameras see a room from two places, which every stage needs that finds depth by rays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from followspot.errors import Mistake
from followspot.room import Camera

_SAME = 1e-6
"""Distance up to which two cameras stand at one place, m: as rooms are before they are calibrated."""
_MOST_NAMED = 3


def check_two_views(cameras: Sequence[Camera], need: str) -> Iterator[Mistake]:
    """A warning for `Stage.check_room` if these cameras do not see the room from two places.

    need: what needs two cameras, for example "a pair needs blobs of". Nothing is known of a stage that a
    source feeds which serves no camera: it may send for several.
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
