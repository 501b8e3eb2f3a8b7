"""Base of the recordings of simulated rooms: an end, and lossless videos."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
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


@contextmanager
def new_video(path: Path, fps: float, size: tuple[int, int], frames: int) -> Iterator[cv2.VideoWriter]:
    """A lossless video to write so many colour pictures of this size into.

    Raises FollowspotError if it cannot be opened, and at the end if it is not whole: OpenCV tells nothing of
    a full disk.
    """
    video = cv2.VideoWriter(opencv_name(path), cv2.VideoWriter.fourcc(*"FFV1"), fps, size, True)
    if not video.isOpened():
        raise FollowspotError(f"{path}: cannot write a video; is the folder writable and the disk not full?")
    try:
        yield video
    finally:
        video.release()
    if not path.exists():
        text = f"{path} was moved or removed while it was written"
        raise FollowspotError(f"{text}\n    simulate again, and leave the folder until the end")
    if _stated_frames(path) < max(1, frames - 1):  # it follows from the duration, which is rounded to ms
        raise FollowspotError(f"{path} is cut short\n    free space on the disk or simulate fewer frames")


def _stated_frames(path: Path) -> int:
    """How many pictures a video has as it says at its end; none without one."""
    video = cv2.VideoCapture(opencv_name(path), cv2.CAP_FFMPEG)
    try:
        return int(video.get(cv2.CAP_PROP_FRAME_COUNT)) if video.isOpened() else 0
    finally:
        video.release()
