"""Recordings with pictures of another size than the calibration's, and the camera for them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.errors import InputError
from followspot_cameras.images import read_picture
from followspot_cameras.picture_folder import natural_order
from followspot_cameras.video.file import open_video

BLOCK = 16
"""Codecs store whole blocks of so many px; what they add right and below is cut off when playing."""
SAME_SHAPE = 0.005
"""Largest relative difference between the scales of width and height."""


def picture_size(recording: Path) -> tuple[int, int] | None:
    """Width and height of a video's pictures, rotated as the file says, or of a folder's first picture.

    None if there is no picture yet. Raises InputError for a video that is none.
    """
    if recording.is_dir():
        files = natural_order(recording, "*")
        picture = read_picture(files[0]) if files else None
    else:
        video = open_video(recording)
        picture = video.read()[1]
        video.release()
    return None if picture is None else (int(picture.shape[1]), int(picture.shape[0]))


def as_recorded(camera: Camera, size: tuple[int, int] | None) -> tuple[Camera, str]:
    """The camera with pictures of this size, and what was changed; "" for nothing.

    Pictures that lack less than a codec's block at the right or below were cut there, so the matrix holds;
    pictures of the same shape are a scaled view. Raises InputError for others.
    """
    if size is None or size == camera.size:
        return camera, ""
    was, now = np.array(camera.size), np.array(size)
    text = f"camera {camera.name} was calibrated at {was[0]}x{was[1]} px and recorded at {now[0]}x{now[1]} px"
    if ((now <= was) & (was - now < BLOCK)).all() and (was[now < was] % BLOCK == 0).all():
        return replace(camera, size=size), f"{text}: taken as cut off at the right and below"
    scale = now / was
    if abs(scale[0] / scale[1] - 1) > SAME_SHAPE:
        remedy = "give the recording that belongs to the calibration, or calibrate the camera at this size"
        raise InputError.of(text, remedy)
    matrix = camera.matrix.copy()
    matrix[:2] *= scale[:, None]
    matrix[:2, 2] = (camera.matrix[:2, 2] + 0.5) * scale - 0.5
    return replace(camera, size=size, matrix=matrix), f"{text}: taken as the same view, scaled"
