"""When the frames of a video were captured: by its rate, by its own time stamps, or by a list beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import ClassVar, Self

import cv2
from pydantic import field_validator, model_validator

from followspot import Field, InputPath
from followspot.errors import InputError
from followspot.frame_times import capture_time
from followspot_cameras.recorded_times.params import TimesParams, read_times
from followspot_cameras.video.container import is_matroska
from followspot_cameras.video.file import announced_frames, frame_rate

SLOWEST = 0.001
"""Smallest frame rate, 1/s."""


class VideoParams(TimesParams):
    """A video, and what decides the capture times of its frames."""

    path: InputPath = Field(description="the video file")
    fps: float = Field(
        0.0, ge=0, le=100_000, unit="1/s", description="frame rate; 0: as the file says, or by recorded times"
    )
    time_stamps: bool = Field(
        False, description="capture times are the file's own time stamps, as of Matroska, not its frame rate"
    )

    @field_validator("fps")
    @classmethod
    def rate_of_its_own(cls, fps: float) -> float:
        """Refuse a rate that no ratio of small numbers comes near to."""
        if 0 < fps < SLOWEST:
            raise ValueError(f"a frame rate is 0 or at least {SLOWEST}")
        return fps

    @model_validator(mode="after")
    def one_clock(self) -> Self:
        """Refuse two sources of capture times."""
        given = [name for name in ("times", "time_stamps", "fps") if getattr(self, name)]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)} each give capture times: keep one of them")
        return self


@dataclass(frozen=True)
class RegularTimes:
    """Frame f is captured at f / rate after the start, ns."""

    regular: ClassVar[bool] = True
    rate: Fraction
    start: int

    def time_of(self, number: int) -> int:
        """Ns"""
        return self.start + capture_time(number, self.rate)

    def announced(self, capture: cv2.VideoCapture) -> int:
        """Number of frames as the container states it."""
        return int(capture.get(cv2.CAP_PROP_FRAME_COUNT))


@dataclass
class TimeStamps:
    """The frame that was read last is captured at its time stamp in the file; the first one has 0."""

    regular: ClassVar[bool] = False
    path: Path
    capture: cv2.VideoCapture
    start: int
    last: int = -1

    def time_of(self, number: int) -> int:
        """Ns. Raises InputError unless time stamps rise from frame to frame."""
        time = round(self.capture.get(cv2.CAP_PROP_POS_MSEC) * 1e6)
        if time <= self.last:
            text = f"{self.path}: frame {number} has no later time stamp than the one before it"
            raise InputError.of(text, "leave out time_stamps, or give the times beside the file by times")
        self.last = time
        return self.start + time

    def announced(self, capture: cv2.VideoCapture) -> int:
        """0: with irregular times the number of frames that a container tells is a guess."""
        return 0


@dataclass(frozen=True)
class ListedTimes:
    """Frame f is captured at the f-th time of a list, ns."""

    regular: ClassVar[bool] = False
    path: Path
    source: Path
    times: Sequence[int]
    start: int

    @classmethod
    def read(cls, path: Path, source: Path, camera: str, start: int) -> Self:
        """The times of a video in a file beside it. Raises InputError if the video has another number."""
        found = cls(path, source, read_times(source, camera), start)
        stated = 0 if is_matroska(path) else announced_frames(path)
        if stated and stated != len(found.times):
            raise found.contradiction(f"{stated} frames")
        return found

    def time_of(self, number: int) -> int:
        """Ns. Raises InputError if there are fewer times than frames."""
        if number >= len(self.times):
            raise self.contradiction("more frames")
        return self.start + self.times[number]

    def announced(self, capture: cv2.VideoCapture) -> int:
        """Number of times."""
        return len(self.times)

    def contradiction(self, frames: str) -> InputError:
        """The video has other frames than the list has times."""
        text = f"times: {self.source} has {len(self.times)} times for {self.path}, which has {frames}"
        return InputError.of(text, "give the times that were written with this recording")


FrameTimes = RegularTimes | TimeStamps | ListedTimes


def times_of(params: VideoParams, capture: cv2.VideoCapture, camera: str) -> FrameTimes:
    """How the frames of an open video get their capture times. Raises InputError."""
    if params.times is not None:
        return ListedTimes.read(params.path, params.times, camera, params.start)
    if params.time_stamps:
        return TimeStamps(params.path, capture, params.start)
    return RegularTimes(frame_rate(capture, params.path, params.fps), params.start)
