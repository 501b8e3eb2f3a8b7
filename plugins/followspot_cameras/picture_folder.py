"""The files of a folder of pictures and their capture times, for all sources that play such folders."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Self, TypeVar

import numpy as np
from pydantic import model_validator

from followspot import Field, InputPath, Message, Source, Stage, at
from followspot.errors import InputError, Mistake
from followspot.frame_times import capture_time, exact_rate
from followspot.room import Member, Room
from followspot_cameras.recorded_times.file_names import in_order_of_time
from followspot_cameras.recorded_times.params import TimesParams, read_times

M = TypeVar("M", bound=Message)
SUFFIXES = frozenset({".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp"})


FEWEST, STEADY = 5, 0.9
"""Pictures whose names are numbers that rise evenly, and share of the steps between them that are alike."""
MOST_STEP = 1000
"""Largest step between numbers of pictures that are no times."""


class FolderParams(TimesParams):
    """A folder of pictures, and the part of it to play."""

    path: InputPath = Field(description="the folder")
    pattern: str = Field(
        "*", pattern=r"^[^/\\]+$", description="pattern of the file names, for example left*.png"
    )
    name_time: str = Field(
        "",
        max_length=100,
        description="capture times are in the names: the unit (s, ms, us, ns) of the last number, or the "
        "whole name without its ending as a date, for example shot_%Y%m%d_%H%M%S_%f",
    )
    fps: float = Field(
        30.0, ge=0.001, le=100_000, unit="1/s", description="frame rate, unless times are given"
    )
    start_frame: int = Field(0, ge=0, unit="frames", description="number of the first picture to play")
    frames: int = Field(0, ge=0, unit="frames", description="largest number of pictures to play; 0: all")

    @model_validator(mode="after")
    def one_clock(self) -> Self:
        """Refuse two sources of capture times."""
        if self.times and self.name_time:
            raise ValueError("times and name_time both give capture times: leave one out")
        return self


class PictureFolder(Stage):
    """Base of the sources that play the pictures of a folder in the natural order of their names."""

    per_camera = True
    suffixes = SUFFIXES
    """Endings of the files that are pictures."""

    params: FolderParams

    @classmethod
    def check_files(cls, params: FolderParams, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Read recorded capture times. Raises InputError."""
        if params.times or params.name_time:
            pictures_of(params, cls.suffixes, member.name if member is not None else "")
        return ()

    def setup(self) -> None:
        """List the folder. Raises InputError if it has no such pictures, or no times for them."""
        pictures = pictures_of(self.params, self.suffixes, self.camera.name)
        self.files, self.times = list(pictures), list(pictures.values())
        if gap := gap_of(self.params, self.files):
            self.context.warn(f"{gap}, and all later ones are played too early: give their times")

    def length(self) -> int:
        """Number of pictures."""
        return len(self.chosen)

    def capture_time(self, number: int) -> int:
        """When the picture was taken, ns."""
        return self.times[self.params.start_frame + number]

    @property
    def chosen(self) -> list[Path]:
        """The files between `start_frame` and the last frame."""
        first, frames = self.params.start_frame, self.params.frames
        return self.files[first : first + frames if frames else None]

    def played(self, message_of: Callable[[Path], M | None]) -> Source[M]:
        """Messages with their capture time and their number in the folder; unreadable files leave a gap.

        message_of: the message of a file, None if it cannot be read.
        """
        unreadable = []
        for number, path in enumerate(self.chosen, self.params.start_frame):
            message = message_of(path)
            if message is None:
                unreadable.append(path.name)
                continue
            yield at(self.times[number], message, seq=number)
        if unreadable:
            self.context.warn(f"{len(unreadable)} pictures cannot be read, the first is {unreadable[0]}")


def pictures_of(params: FolderParams, suffixes: frozenset[str], camera: str) -> dict[Path, int]:
    """The pictures that the parameters choose, in order, and when each was taken, ns.

    Raises InputError if there are none, and where recorded times are missing or contradict the pictures.
    """
    files = natural_order(params.path, params.pattern, suffixes)
    if not files:
        text = f'{params.path} has no pictures "{params.pattern}"'
        raise InputError.of(text, f"pictures end in {', '.join(sorted(suffixes))}")
    if params.name_time:
        named = in_order_of_time(files, params.name_time)
        return {path: params.start + time for path, time in named.items()}
    if params.times is None:
        rate = exact_rate(params.fps)
        return {path: params.start + capture_time(number, rate) for number, path in enumerate(files)}
    times = read_times(params.times, camera)
    if len(times) != len(files):
        text = f"times: {params.path} has {len(files)} pictures, {params.times.name} times of {len(times)}"
        raise InputError.of(text, f"give the times of all pictures of camera {camera} and of no other")
    return {path: params.start + time for path, time in zip(files, times, strict=True)}


def natural_order(folder: Path, pattern: str, suffixes: frozenset[str] = SUFFIXES) -> list[Path]:
    """Picture files of the folder that match, numbers in their names compared as numbers."""
    inside = folder.iterdir() if folder.is_dir() else ()
    files = (p for p in inside if p.suffix.lower() in suffixes and fnmatchcase(p.name, pattern))
    return sorted(files, key=lambda p: [int(t) if t.isdigit() else t for t in re.split(r"([0-9]+)", p.name)])


def gap_of(params: FolderParams, files: Sequence[Path]) -> str:
    """The first gap in the numbers of names of pictures that come at a rate, as text; "" if none."""
    named = [re.findall(r"\d+", path.stem)[-1:] for path in files]
    if params.name_time or params.times is not None or len(files) < FEWEST or not all(named):
        return ""
    step = np.diff([int(number[0][:18]) for number in named])
    usual = np.bincount(np.clip(step, 0, MOST_STEP)).argmax()
    beyond = np.flatnonzero(step > usual)
    if not usual or not len(beyond) or np.mean(step == usual) < STEADY:
        return ""
    row = int(beyond[0])
    return f"between {files[row].name} and {files[row + 1].name} pictures are missing"
