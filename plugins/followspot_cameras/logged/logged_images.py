"""Parameters and capture times of all sources that play the pictures of a log file."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import ClassVar

from followspot import Field, InputPath, Source, Stage, StageParams, at
from followspot.errors import Mistake
from followspot.frame_times import to_ns
from followspot.messages import MAX_TIME
from followspot.room import Member, Room
from followspot.tracking import Frame
from followspot_cameras.logged.stored_image import StoredImage
from followspot_cameras.picture import as_frame, check_size

LARGEST_TIME = MAX_TIME // 2


class LogParams(StageParams):
    """A log file, and the part of it to play."""

    path: InputPath = Field(description="the log file")
    topic: str = Field("", max_length=500, description="topic of the pictures; empty if there is only one")
    start_frame: int = Field(0, ge=0, unit="frames", description="number of the first picture to play")
    frames: int = Field(0, ge=0, unit="frames", description="largest number of pictures to play; 0: all")
    start_time: float = Field(
        0.0, ge=-4e9, le=4e9, unit="s", description="added to the capture times; negative to begin near 0"
    )


@dataclass(frozen=True)
class Pictures:
    """The pictures of a topic in the order of the log, None for one that cannot be read; count: how many."""

    images: Iterator[StoredImage | None]
    count: int


class LoggedImages(Stage):
    """Base of the sources that play the pictures of a log file, at the times that its messages tell."""

    per_camera: ClassVar[bool] = True
    params: LogParams

    @classmethod
    @abstractmethod
    def opened(cls, params: LogParams) -> AbstractContextManager[Pictures]:
        """The pictures of an open file. Raises InputError."""

    @classmethod
    def check_files(cls, params: LogParams, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Read the first picture. Raises InputError."""
        with cls.opened(params) as pictures:
            first = next(pictures.images, None)
        if first is None:
            yield Mistake(None, f"path: {params.path} begins with no picture", "choose another topic")

    def setup(self) -> None:
        """Count the pictures. Raises InputError."""
        with self.opened(self.params) as pictures:
            self.count = pictures.count

    def length(self) -> int:
        """Number of pictures."""
        total = max(0, self.count - self.params.start_frame)
        return min(total, self.params.frames or total)

    def process(self) -> Source[Frame]:
        """Pictures with their capture time and their number among those of the topic.

        Pictures that cannot be decoded, and those that are no later than one before them, leave a gap.
        """
        p, camera = self.params, self.camera
        fits = partial(check_size, camera=camera, origin=str(p.path))
        start, last, damaged, late = to_ns(p.start_time), -LARGEST_TIME, 0, 0
        with self.opened(p) as pictures:
            stop = p.start_frame + p.frames if p.frames else None
            for number, image in islice(enumerate(pictures.images), p.start_frame, stop):
                pixels = None if image is None else image.decoded(fits)
                if image is None or pixels is None or abs(image.time) > LARGEST_TIME:
                    damaged += 1
                elif image.time <= last:
                    late += 1
                else:
                    last = image.time
                    frame = as_frame(pixels, camera, self.context.loan, str(p.path))
                    yield at(start + last, frame, seq=number)
        if damaged:
            self.context.warn(f"{p.path.name}: {damaged} pictures cannot be read")
        if late:
            text = f"{late} pictures are left out: they are no later than one before"
            self.context.warn(f"{p.path.name}: {text}")
