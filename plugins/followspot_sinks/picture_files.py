"""Pictures written as a video or one file each, below the run's output folder."""

from __future__ import annotations

import errno
import math
import os
from collections.abc import Sequence
from pathlib import Path
from resource import RLIM_INFINITY, RLIMIT_FSIZE, getrlimit
from typing import NoReturn, Protocol

import cv2
import numpy as np

from followspot.errors import FollowspotError
from followspot.files import opencv_name
from followspot.messages import Array
from followspot.operating_system.limits import limit_remedy

SMALLEST = 16
"""Smallest width and height for the codec, px; it needs even ones."""
LEAST_SPACE = 1 << 20
"""Bytes that must be free on the disk: an .mp4 that is cut off cannot be played at all."""
SLOWEST, FASTEST = 1.0, 240.0
"""Smallest and largest frame rate of a video, 1/s."""


class PictureFile(Protocol):
    """A file for the pictures of one camera."""

    def write(self, picture: Array, seq: int, time: int) -> None:
        """Add a picture (H, W, 3) BGR, its number and capture time, ns. Raises FollowspotError."""

    def close(self) -> None:
        """Complete the file."""


class VideoFile:
    """A video with the frame rate of the first two pictures.

    A player opens an .mp4 only if it is complete; it plays an .mkv up to the place where writing ended.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.first: tuple[Array, int] | None = None
        self.writer: cv2.VideoWriter | None = None

    def write(self, picture: Array, seq: int, time: int) -> None:
        """Add a picture; the first waits for the second, which gives the rate. Raises FollowspotError."""
        picture = fitted(picture)
        self._require_file()
        if self.writer is not None:
            self.writer.write(picture)
        elif self.first is None:
            self.first = picture, time
        else:
            self._open(self.first[0], 1e9 / max(1, time - self.first[1])).write(picture)

    def close(self) -> None:
        """Complete the file, also of a single picture. Raises FollowspotError."""
        if self.writer is None and self.first is not None:
            self._open(self.first[0], SLOWEST)
        if self.writer is not None:
            self.writer.release()  # it tells no errors
            self._require_file()

    def _require_file(self) -> None:
        """Raises FollowspotError if the video is gone or may grow no more: its writer tells neither."""
        try:
            size = 0 if self.writer is None else self.path.stat().st_size
            found = os.statvfs(self.path.parent)
        except FileNotFoundError:
            raise FollowspotError(f"{self.path} was moved or removed while the run wrote it") from None
        most, _ = getrlimit(RLIMIT_FSIZE)
        if found.f_bavail * found.f_frsize < LEAST_SPACE:
            self._refuse(errno.ENOSPC)
        if most != RLIM_INFINITY and most - size < LEAST_SPACE:
            self._refuse(errno.EFBIG)

    def _refuse(self, number: int) -> NoReturn:
        error = OSError(number, os.strerror(number))
        remedy = limit_remedy(error, "free space on the disk or choose another output folder")
        raise FollowspotError(f"{self.path} cannot be written: {error.strerror}\n    {remedy}")

    def _open(self, first: Array, rate: float) -> cv2.VideoWriter:
        height, width = first.shape[:2]
        rate = min(max(rate, SLOWEST), FASTEST)
        name, codec = opencv_name(self.path), cv2.VideoWriter.fourcc(*"mp4v")
        self.writer = cv2.VideoWriter(name, codec, rate, (width, height))
        if not self.writer.isOpened():
            raise FollowspotError(
                f"{self.path} cannot be written as a video\n    draw pictures instead: format: jpg"
            )
        self.writer.write(first)
        return self.writer


def fitted(picture: Array) -> Array:
    """The picture with a black margin at the right and below if the codec needs one."""
    missing = [max(SMALLEST, side + side % 2) - side for side in picture.shape[:2]]
    if not any(missing):
        return picture
    return np.pad(picture, ((0, missing[0]), (0, missing[1]), (0, 0)))


def side_by_side(pictures: Sequence[Array]) -> Array:
    """Pictures in rows and columns, each in a cell of the size of the largest: about as wide as three to two.

    pictures: (H, W, 3) each, one or more.
    """
    columns = math.ceil(math.sqrt(len(pictures) * 1.5)) if len(pictures) > 1 else 1
    height, width = (max(sides) for sides in zip(*(p.shape[:2] for p in pictures), strict=True))
    rows = math.ceil(len(pictures) / columns)
    grid = np.zeros((rows * height, columns * width, 3), np.uint8)
    for number, picture in enumerate(pictures):
        top, left = number // columns * height, number % columns * width
        grid[top : top + picture.shape[0], left : left + picture.shape[1]] = picture
    return grid


class PictureFolder:
    """A folder with a file for each picture, named by its number; form: jpg or png."""

    def __init__(self, folder: Path, camera: str, form: str) -> None:
        self.form = form
        self.folder = folder / camera
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FollowspotError(f"{self.folder} cannot be written: {error.strerror}") from None

    def write(self, picture: Array, seq: int, time: int) -> None:
        """Write one file. Raises FollowspotError."""
        path = self.folder / f"{seq:06d}.{self.form}"
        if not cv2.imwrite(opencv_name(path), picture):
            if not self.folder.is_dir():
                raise FollowspotError(f"{self.folder} was moved or removed while the run wrote it")
            raise FollowspotError(f"{path} cannot be written\n    free space on the disk")

    def close(self) -> None:
        """Every file is complete."""
