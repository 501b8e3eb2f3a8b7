"""A replay for each message type of followspot, and one for all others.

A port's type stands in a signature, so each type has a stage of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from followspot import Message, Source, Stage
from followspot.errors import FollowspotError
from followspot.people import Appearances, Boxes, Gradients, Poses, PoseTruth
from followspot.tracking import (
    Blobs,
    Candidates,
    Forecast,
    Frame,
    ImageTracks,
    Pairs,
    Positions,
    Tracks,
    Truth,
)
from followspot_recording.replay import Replay

REPLAYS: Mapping[str, type[Message]] = {
    "frame": Frame,
    "blobs": Blobs,
    "pairs": Pairs,
    "candidates": Candidates,
    "positions": Positions,
    "forecast": Forecast,
    "tracks": Tracks,
    "truth": Truth,
    "image_tracks": ImageTracks,
    "gradients": Gradients,
    "boxes": Boxes,
    "appearances": Appearances,
    "poses": Poses,
    "pose_truth": PoseTruth,
}
"""What each stage `recording.NAME` replays."""


class ReplayFrame(Replay):
    """Recorded pictures."""

    def process(self) -> Source[Frame]:
        """The messages of the port, in order."""
        yield from self.messages(Frame)


class ReplayBlobs(Replay):
    """Recorded blobs."""

    def process(self) -> Source[Blobs]:
        """The messages of the port, in order."""
        yield from self.messages(Blobs)


class ReplayPairs(Replay):
    """Recorded pairs of blobs."""

    def process(self) -> Source[Pairs]:
        """The messages of the port, in order."""
        yield from self.messages(Pairs)


class ReplayCandidates(Replay):
    """Recorded candidates."""

    def process(self) -> Source[Candidates]:
        """The messages of the port, in order."""
        yield from self.messages(Candidates)


class ReplayPositions(Replay):
    """Recorded fused positions."""

    def process(self) -> Source[Positions]:
        """The messages of the port, in order."""
        yield from self.messages(Positions)


class ReplayForecast(Replay):
    """Recorded forecasts."""

    def process(self) -> Source[Forecast]:
        """The messages of the port, in order."""
        yield from self.messages(Forecast)


class ReplayTracks(Replay):
    """Recorded tracks."""

    def process(self) -> Source[Tracks]:
        """The messages of the port, in order."""
        yield from self.messages(Tracks)


class ReplayTruth(Replay):
    """Recorded ground truth."""

    def process(self) -> Source[Truth]:
        """The messages of the port, in order."""
        yield from self.messages(Truth)


class ReplayImageTracks(Replay):
    """Recorded tracks in pictures."""

    def process(self) -> Source[ImageTracks]:
        """The messages of the port, in order."""
        yield from self.messages(ImageTracks)


class ReplayGradients(Replay):
    """Recorded gradients."""

    def process(self) -> Source[Gradients]:
        """The messages of the port, in order."""
        yield from self.messages(Gradients)


class ReplayBoxes(Replay):
    """Recorded boxes of upper bodies."""

    def process(self) -> Source[Boxes]:
        """The messages of the port, in order."""
        yield from self.messages(Boxes)


class ReplayAppearances(Replay):
    """Recorded appearances of persons."""

    def process(self) -> Source[Appearances]:
        """The messages of the port, in order."""
        yield from self.messages(Appearances)


class ReplayPoses(Replay):
    """Recorded poses of persons."""

    def process(self) -> Source[Poses]:
        """The messages of the port, in order."""
        yield from self.messages(Poses)


class ReplayPoseTruth(Replay):
    """Recorded true poses of persons."""

    def process(self) -> Source[PoseTruth]:
        """The messages of the port, in order."""
        yield from self.messages(PoseTruth)


class ReplayPort(Replay):
    """Recorded messages of a plugin's own type: `recording.port[STAGE.PORT]` for what that stage sends."""

    @classmethod
    def for_type(cls, kind: type[Message]) -> type[Stage]:
        """The replay of this type."""

        def process(self: Replay) -> Any:
            """The messages of the port, in order."""
            yield from self.messages(kind)

        process.__annotations__["return"] = Source[kind]  # type: ignore[valid-type]
        return type(f"Replay{kind.__name__}", (Replay,), {"__doc__": cls.__doc__, "process": process})

    def setup(self) -> None:
        """Say what is missing. Raises FollowspotError."""
        raise FollowspotError(f"{self.context.name} has no type; write uses: recording.port[STAGE.PORT]")

    def process(self) -> Source[Message]:
        """The messages of the port, in order."""
        yield from self.messages(Message)
