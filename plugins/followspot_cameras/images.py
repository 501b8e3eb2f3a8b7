"""A folder of pictures as a camera."""

from __future__ import annotations

import re
from fnmatch import fnmatchcase
from pathlib import Path

import cv2

from followspot import Field, InputPath, Source, Stage, StageParams, at
from followspot.errors import InputError, Mistake
from followspot.files import PICTURE, require_regular
from followspot.messages import Array
from followspot.tracking import Frame
from followspot_cameras.clock import capture_time, exact_rate
from followspot_cameras.picture import as_frame

SUFFIXES = frozenset({".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp"})


class Images(Stage):
    """Play the pictures of a folder in the natural order of their names (frame2 before frame10)."""

    per_camera = True

    class Params(StageParams):
        path: InputPath = Field(description="the folder")
        pattern: str = Field(
            "*", pattern=r"^[^/\\]+$", description="pattern of the file names, for example left*.png"
        )
        fps: float = Field(30.0, ge=0.001, le=100_000, unit="1/s", description="frame rate")
        start_frame: int = Field(0, ge=0, unit="frames", description="number of the first picture to play")
        frames: int = Field(0, ge=0, unit="frames", description="largest number of pictures to play; 0: all")

    params: Params

    def setup(self) -> None:
        """List the folder. Raises InputError if it has no such pictures."""
        self.files = natural_order(self.params.path, self.params.pattern)
        if not self.files:
            raise InputError(
                [
                    Mistake(
                        None,
                        f'{self.params.path} has no pictures "{self.params.pattern}"',
                        f"pictures end in {', '.join(sorted(SUFFIXES))}",
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

    def process(self) -> Source[Frame]:
        """Frames with their capture time and their number in the folder; unreadable files leave a gap."""
        rate = exact_rate(self.params.fps)
        unreadable = []
        for number, path in enumerate(self.chosen, self.params.start_frame):
            image = read_picture(path)
            if image is None:
                unreadable.append(path.name)
                continue
            frame = as_frame(image, self.camera, self.context.loan, str(path))
            yield at(capture_time(number, rate), frame, seq=number)
        if unreadable:
            self.context.warn(f"{len(unreadable)} pictures cannot be read, the first is {unreadable[0]}")


def read_picture(path: Path, flags: int = cv2.IMREAD_COLOR) -> Array | None:
    """The picture, (H, W, 3) uint8 unless flags say otherwise.

    None if it cannot be read, has more than `PICTURE` bytes, or claims a size beyond all reason.
    """
    try:
        require_regular(path, PICTURE)
        return cv2.imread(str(path), flags)
    except (OSError, cv2.error):
        return None


def natural_order(folder: Path, pattern: str) -> list[Path]:
    """Picture files of the folder that match, numbers in their names compared as numbers."""
    inside = folder.iterdir() if folder.is_dir() else ()
    files = (p for p in inside if p.suffix.lower() in SUFFIXES and fnmatchcase(p.name, pattern))
    return sorted(files, key=lambda p: [int(t) if t.isdigit() else t for t in re.split(r"([0-9]+)", p.name)])
