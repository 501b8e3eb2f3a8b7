"""A recorded video as a camera."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path

import cv2

from followspot import Field, InputPath, Source, Stage, StageParams, at
from followspot.errors import InputError, Mistake
from followspot.files import require_regular
from followspot.frame_times import capture_time, exact_rate
from followspot.room import Member, Room
from followspot.tracking import Frame
from followspot_cameras.container import cut_off
from followspot_cameras.picture import as_frame, check_size, color_buffer


class Video(Stage):
    """Play a video file as the camera's pictures; frame f is captured at f / fps.

    Frames that cannot be decoded leave a gap in the numbers if the file has time stamps. They are reported at
    the end, as is a file that ends early.
    """

    per_camera = True

    class Params(StageParams):
        path: InputPath = Field(description="the video file")
        fps: float = Field(0.0, ge=0, le=100_000, unit="1/s", description="frame rate; 0: as the file says")
        start_frame: int = Field(0, ge=0, unit="frames", description="number of the first frame to play")
        frames: int = Field(0, ge=0, unit="frames", description="largest number of frames to play; 0: all")

    params: Params
    capture = cv2.VideoCapture()  # plays nothing until setup

    @classmethod
    def check_files(cls, params: Params, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Warn if the file is cut off: it plays, and its end would come as a surprise."""
        if missing := cut_off(params.path):
            text = f"path: {params.path.name} ends early{missing}"
            yield Mistake(None, text, "copy the recording again", warning=True)

    def setup(self) -> None:
        """Open the file. Raises InputError if it is no video, has another size or states no frame rate."""
        path = self.params.path
        self.capture = open_video(path)
        width = int(self.capture.get(cv2.CAP_PROP_FRAME_WIDTH))
        height = int(self.capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
        check_size(width, height, self.camera, str(path))
        self.rate = frame_rate(self.capture, path, self.params.fps)
        self.damaged = 0

    def length(self) -> int | None:
        """Number of frames as the container states it; None if its time stamps are unusable."""
        total = announced_frames(self.params.path) - self.params.start_frame
        return min(total, self.params.frames or total) if total > 0 else None

    def process(self) -> Source[Frame]:
        """Frames with their capture time and the number that they have in the file."""
        camera, loan = self.camera, self.context.loan
        first = self.params.start_frame
        last = first + self.params.frames - 1 if self.params.frames else None
        for number in self.numbered(last):
            if number < first:
                continue
            ok, image = self.capture.retrieve(color_buffer(camera, loan))
            if not ok:
                self.damaged += 1
                continue
            frame = as_frame(image, camera, loan, str(self.params.path))
            yield at(capture_time(number, self.rate), frame, seq=number)
        if self.damaged:
            self.context.warn(f"{self.params.path.name}: {self.damaged} frames are missing or damaged")

    def numbered(self, last: int | None) -> Iterator[int]:
        """Grab one picture after the other up to number `last` and give each its number.

        The number follows the time stamp if that leaps, because then frames before it are damaged.
        """
        number, origin = -1, None
        while last is None or number < last:
            if not self.capture.grab():
                self.warn_of_early_end(number + 1)
                break
            stamp = int(self.capture.get(cv2.CAP_PROP_PTS))
            origin = stamp if origin is None else origin
            leap = max(0, stamp - origin - number - 1)
            self.damaged += leap
            number += 1 + leap
            if last is None or number <= last:
                yield number

    def warn_of_early_end(self, played: int) -> None:
        """Warn if fewer frames came than the container announced."""
        path = self.params.path
        total = int(self.capture.get(cv2.CAP_PROP_FRAME_COUNT))
        missing = cut_off(path)
        if total > played:
            self.context.warn(f"{path.name} ended after {played} of {total} frames{missing}")
        elif missing:
            self.context.warn(f"{path.name} ended after {played} frames{missing}")

    def close(self) -> None:
        """Close the file."""
        self.capture.release()


def open_video(path: Path) -> cv2.VideoCapture:
    """A decoder with a second thread that decodes ahead of the graph. Raises InputError."""
    try:
        require_regular(path)
    except OSError as error:
        text = f"{path} cannot be read as a video: {error.strerror}"
        raise InputError([Mistake(None, text, "give the file of a recording")]) from None
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG, [cv2.CAP_PROP_N_THREADS, 2])
    if not capture.isOpened():
        raise InputError(
            [
                Mistake(
                    None,
                    f"{path} cannot be read as a video{cut_off(path)}",
                    "give a whole file that ffmpeg can decode, for example .mkv, .mp4 or .avi",
                )
            ]
        )
    return capture


def announced_frames(path: Path) -> int:
    """Number of frames as the container states it; 0 if its time stamps do not advance."""
    capture = open_video(path)
    try:
        advancing = capture.grab() and capture.grab() and capture.get(cv2.CAP_PROP_PTS) >= 1
        return int(capture.get(cv2.CAP_PROP_FRAME_COUNT)) if advancing else 0
    finally:
        capture.release()


def frame_rate(capture: cv2.VideoCapture, path: Path, given: float) -> Fraction:
    """Frames per second: as given, or as the file states it. Raises InputError if neither does."""
    try:
        return exact_rate(given or capture.get(cv2.CAP_PROP_FPS))
    except (ValueError, OverflowError):
        raise InputError(
            [Mistake(None, f"{path} does not state its frame rate", 'give it: "fps: 30"')]
        ) from None
