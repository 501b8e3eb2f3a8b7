"""Dots shown one after the other on a plane, found in the clips of several cameras."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from followspot import Camera
from followspot.errors import InputError
from followspot.messages import Array
from followspot_balls.templates.glowing_spot import brightness
from followspot_calibrate.clips import folders_of, read_frames
from followspot_calibrate.planes.marks import Marks, sightings
from followspot_cameras.recordings import find_recordings

MOST_FRAMES = 1000
"""Largest number of dots of one clip, that is, on one plane."""
CONTRAST = 30.0
"""Smallest brightness of a dot above the room without it, grey levels."""
UNIQUE = 0.6
"""Brightness of the second spot over that of the first, above which it is not clear which is the dot."""
REACH = 7
"""Half the side of the window around a dot's brightest pixel, px."""
RIM = 0.25
"""Brightness of a dot's rim over that of its peak."""
BLUR = 1.0
"""Blur before the search for the brightest pixel, px; it removes hot pixels."""


def find_marks(clips: Path, cameras: Sequence[Camera]) -> Marks:
    """Dots on each plane from CLIPS/<plane>/<camera>.mkv; the frame's number says which dot it is.

    Raises InputError if a plane has clips of fewer than two cameras.
    """
    marks = {}
    for folder in folders_of(clips, "plane"):
        recordings = find_recordings(folder, [camera.name for camera in cameras])
        if len(recordings) < 2:
            text = f"{folder} has clips of {len(recordings)} of the room's cameras"
            raise InputError.of(text, "a plane is measured by two cameras or more")
        points: dict[int, dict[int, list[float]]] = {}
        for number, camera in enumerate(cameras):
            if camera.name in recordings:
                frames = read_frames(recordings[camera.name], camera, MOST_FRAMES)
                for frame, place in enumerate(dots([brightness(picture) for picture in frames])):
                    if place is not None:
                        points.setdefault(frame, {})[number] = place.tolist()
        marks[folder.name] = sightings(cameras, [points[frame] for frame in sorted(points)])
    return marks


def dots(levels: Sequence[Array]) -> list[Array | None]:
    """The dot in each picture, (2,) px, sub-pixel; None if there is none or it is not clear which it is.

    levels: (H, W) u8 pictures; the room without dots is their median.
    """
    if not levels:
        return []
    stack = np.stack(levels)
    room = np.median(stack, axis=0).astype(np.float32) if len(stack) > 2 else np.zeros(stack.shape[1:], "f4")
    return [_dot(np.maximum(level - room, 0)) for level in stack]


def _dot(risen: Array) -> Array | None:
    """The only bright spot of a picture, its centroid weighted by brightness: (H, W) -> (2,) px."""
    smooth = cv2.GaussianBlur(risen, (0, 0), BLUR)
    y, x = np.unravel_index(smooth.argmax(), smooth.shape)
    peak = float(smooth[y, x])
    if peak < CONTRAST:
        return None
    top, left = max(int(y) - REACH, 0), max(int(x) - REACH, 0)
    window = np.s_[top : int(y) + REACH + 1, left : int(x) + REACH + 1]
    # Counted from the rim, at which the weight is 0: whole pixels at the edge would shift the centre.
    weight = np.maximum(smooth[window] - RIM * peak, 0)
    smooth[window] = 0
    if smooth.max() > UNIQUE * peak:
        return None
    rows, columns = np.indices(weight.shape)
    total = weight.sum()
    return np.array([left + (columns * weight).sum() / total, top + (rows * weight).sum() / total])
