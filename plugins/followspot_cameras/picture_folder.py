"""What all sources share that play the pictures of a folder: which files, and when each was taken."""

from __future__ import annotations

import re
from collections.abc import Callable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TypeVar

from followspot import Field, InputPath, Message, Source, Stage, StageParams, at
from followspot.errors import InputError, Mistake
from followspot.frame_times import capture_time, exact_rate

M = TypeVar("M", bound=Message)
SUFFIXES = frozenset({".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp"})


class FolderParams(StageParams):
    """A folder of pictures, and the part of it to play."""

    path: InputPath = Field(description="the folder")
    pattern: str = Field(
        "*", pattern=r"^[^/\\]+$", description="pattern of the file names, for example left*.png"
    )
    fps: float = Field(30.0, ge=0.001, le=100_000, unit="1/s", description="frame rate")
    start_frame: int = Field(0, ge=0, unit="frames", description="number of the first picture to play")
    frames: int = Field(0, ge=0, unit="frames", description="largest number of pictures to play; 0: all")


class PictureFolder(Stage):
    """Base of the sources that play the pictures of a folder in the natural order of their names."""

    per_camera = True
    suffixes = SUFFIXES
    """Endings of the files that are pictures."""

    params: FolderParams

    def setup(self) -> None:
        """List the folder. Raises InputError if it has no such pictures."""
        self.files = natural_order(self.params.path, self.params.pattern, self.suffixes)
        if not self.files:
            raise InputError(
                [
                    Mistake(
                        None,
                        f'{self.params.path} has no pictures "{self.params.pattern}"',
                        f"pictures end in {', '.join(sorted(self.suffixes))}",
                    )
                ]
            )

    def length(self) -> int:
        """Number of pictures."""
        return len(self.chosen)

    @property
    def chosen(self) -> list[Path]:
        """The files between `start_frame` and the last frame."""
        first, frames = self.params.start_frame, self.params.frames
        return self.files[first : first + frames if frames else None]

    def played(self, message_of: Callable[[Path], M | None]) -> Source[M]:
        """Messages with their capture time and their number in the folder; unreadable files leave a gap.

        message_of: the message of a file, None if it cannot be read.
        """
        rate = exact_rate(self.params.fps)
        unreadable = []
        for number, path in enumerate(self.chosen, self.params.start_frame):
            message = message_of(path)
            if message is None:
                unreadable.append(path.name)
                continue
            yield at(capture_time(number, rate), message, seq=number)
        if unreadable:
            self.context.warn(f"{len(unreadable)} pictures cannot be read, the first is {unreadable[0]}")


def natural_order(folder: Path, pattern: str, suffixes: frozenset[str] = SUFFIXES) -> list[Path]:
    """Picture files of the folder that match, numbers in their names compared as numbers."""
    inside = folder.iterdir() if folder.is_dir() else ()
    files = (p for p in inside if p.suffix.lower() in suffixes and fnmatchcase(p.name, pattern))
    return sorted(files, key=lambda p: [int(t) if t.isdigit() else t for t in re.split(r"([0-9]+)", p.name)])
