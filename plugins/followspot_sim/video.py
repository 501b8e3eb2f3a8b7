"""What all recordings of simulated rooms need: an end, and lossless videos."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol, TypeVar

import cv2
import pydantic

from followspot import FollowspotError, InputError
from followspot.errors import Mistake
from followspot.files import opencv_name


class _Ending(Protocol):
    frames: int


P = TypeVar("P", bound=_Ending)


def finite(kind: type[P], **values: Any) -> P:
    """Checked parameters of a room that ends. Raises InputError."""
    try:
        params = kind(**values)
    except pydantic.ValidationError as error:
        wrong = [Mistake(None, f"{'.'.join(map(str, e['loc']))}: {e['msg']}", "") for e in error.errors()]
        raise InputError(wrong) from None
    if params.frames == 0:
        raise InputError([Mistake(None, "this room never ends", "say how many frames: --frames 600")])
    return params


def open_video(path: Path, fps: float, size: tuple[int, int]) -> cv2.VideoWriter:
    """A lossless video to write colour pictures of this size into. Raises FollowspotError."""
    video = cv2.VideoWriter(opencv_name(path), cv2.VideoWriter.fourcc(*"FFV1"), fps, size, True)
    if not video.isOpened():
        raise FollowspotError(f"{path}: cannot write a video; is the folder writable and the disk not full?")
    return video
