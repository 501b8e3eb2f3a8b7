"""Small stages that the tests of graphs are made of; loaded as a one-file plugin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from followspot import (
    Array,
    Field,
    InputPath,
    Joined,
    Latest,
    Message,
    Nearest,
    OutputPath,
    Source,
    Stage,
    StageParams,
    Window,
    column,
)
from followspot.tracking import Truth


class Frame(Message):
    pixels: Array = column("H", "W", dtype="u1")


class Blobs(Message):
    xy: Array = column("N", 2, unit="px")


class Forecast(Message):
    xyz: Array = column("N", 3, unit="m")


class Tracks(Message):
    xyz: Array = column("N", 3, unit="m")


@dataclass(frozen=True)
class Tracked:
    tracks: Tracks
    forecast: Forecast


@dataclass(frozen=True)
class Halves:
    left: Blobs
    right: Blobs


class Camera(Stage):
    """A source that serves a camera."""

    per_camera = True

    class Params(StageParams):
        frames: int = Field(10, ge=1, description="length of the recording", unit="frame")
        path: InputPath | None = Field(None, description="where the pictures are")

    def process(self) -> Source[Frame]:
        yield from ()


class Imu(Stage):
    """A source that serves a sensor."""

    per_sensor = True

    class Params(StageParams):
        scale: float = Field(1.0, gt=0, description="factor", unit="1")

    def process(self) -> Source[Forecast]:
        yield from ()


class Device(Camera):
    """A live source."""

    live = True


class Mood(StageParams):
    """A parameter with parameters."""

    gain: float = Field(1.0, gt=0, description="factor", unit="1")


class Detect(Stage):
    """Frames to blobs."""

    class Params(StageParams):
        level: float = Field(0.5, gt=0, le=1, description="least brightness", unit="1")
        start: Literal["cold", "warm"] = Field("cold", description="how it begins")
        weights: list[float] = Field([1.0], description="one per channel", unit="1")
        mood: Mood = Field(Mood(), description="how it feels")

    def process(self, frame: Frame, forecast: Latest[Forecast] = None) -> Blobs:
        return Blobs(frame.pixels)


class Mosaic(Stage):
    """Frames of all cameras to one."""

    def process(self, frames: Joined[Frame]) -> Frame:
        return frames[0]


class Lens(StageParams):
    """Two values in one parameter."""

    gain: float = Field(1.0, gt=0, description="factor", unit="1")
    bias: float = Field(0.0, description="offset", unit="1")


class Through(Detect):
    """Frames to blobs, through a lens."""

    class Params(StageParams):
        lens: Lens = Field(Lens(), description="what it looks through")


class DetectAgain(Detect):
    """Another one."""


class Pair(Stage):
    """Blobs of all cameras to blobs."""

    def process(self, blobs: Joined[Blobs]) -> Blobs:
        return blobs[0]


class PairAgain(Pair):
    """Another one."""


class Masked(Pair):
    """Reads a file."""

    class Params(StageParams):
        mask: InputPath = Field(description="where nothing is to be found")


class Split(Stage):
    """Two outputs of one type."""

    def process(self, blobs: Blobs) -> Halves:
        return Halves(blobs, blobs)


class Track(Stage):
    """Blobs to tracks and a forecast."""

    class Params(StageParams):
        model: str = Field(description="name of the motion model")

    def process(self, blobs: Blobs) -> Tracked:
        return Tracked(Tracks(blobs.xy), Forecast(blobs.xy))


class TrackAgain(Track):
    """With a parameter more."""

    class Params(StageParams):
        model: str = Field(description="name of the motion model")
        gain: float = Field(2.0, description="factor", unit="1")


class Rates(Stage):
    """Takes blobs of other rates."""

    def process(
        self,
        blobs: Blobs,
        window: Window[Blobs] = (),
        near: Nearest[Blobs] = None,
        latest: Latest[Blobs] = None,
    ) -> Blobs:
        return blobs


class Any(Stage):
    """Passes blobs on; takes a hint of any type."""

    def process(self, blobs: Blobs, hint: Message | None = None) -> Blobs:
        return blobs


class Save(Stage):
    """A sink."""

    class Params(StageParams):
        path: OutputPath = Field("tracks.csv", description="the file")

    def process(self, tracks: Tracks) -> None:
        return None


class SaveAgain(Save):
    """Another one, with the same file."""


class Knowing(Stage):
    """A source of truth."""

    class Params(StageParams):
        path: InputPath = Field(description="where it is written")

    def process(self) -> Source[Truth]:
        yield from ()
