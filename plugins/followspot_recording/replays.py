"""A replay for each message type of followspot, and one for all others.

A port's type stands in a signature, so each type has a stage of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from followspot import Message, Source, Stage
from followspot.errors import FollowspotError
from followspot.people import Appearances, Boxes, Gradients, Poses, PoseTruth
from followspot.points import Points2D, Points3D
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
    "points_2d": Points2D,
    "points_3d": Points3D,
}
"""The message types of the stages `recording.NAME`."""


def replay_of(kind: type[Message], description: str) -> type[Replay]:
    """The stage class that replays messages of one type."""

    def process(self: Replay) -> Any:
        """The messages of the port, in order."""
        yield from self.messages(kind)

    process.__annotations__["return"] = Source[kind]  # type: ignore[valid-type]
    body = {"__doc__": description, "__module__": __name__, "process": process}
    return type(f"Replay{kind.__name__}", (Replay,), body)


ReplayFrame = replay_of(Frame, "Recorded pictures.")
ReplayBlobs = replay_of(Blobs, "Recorded blobs.")
ReplayPairs = replay_of(Pairs, "Recorded pairs of blobs.")
ReplayCandidates = replay_of(Candidates, "Recorded candidates.")
ReplayPositions = replay_of(Positions, "Recorded fused positions.")
ReplayForecast = replay_of(Forecast, "Recorded forecasts.")
ReplayTracks = replay_of(Tracks, "Recorded tracks.")
ReplayTruth = replay_of(Truth, "Recorded ground truth.")
ReplayImageTracks = replay_of(ImageTracks, "Recorded tracks in pictures.")
ReplayGradients = replay_of(Gradients, "Recorded gradients.")
ReplayBoxes = replay_of(Boxes, "Recorded boxes of upper bodies.")
ReplayAppearances = replay_of(Appearances, "Recorded appearances of persons.")
ReplayPoses = replay_of(Poses, "Recorded poses of persons.")
ReplayPoseTruth = replay_of(PoseTruth, "Recorded true poses of persons.")
ReplayPoints2D = replay_of(Points2D, "Recorded points in pictures.")
ReplayPoints3D = replay_of(Points3D, "Recorded points in the room.")


class ReplayPort(Replay):
    """Recorded messages of a plugin's own type: `recording.port[STAGE.PORT]` for what that stage sends."""

    @classmethod
    def for_type(cls, kind: type[Message]) -> type[Stage]:
        """The replay of this type."""
        return replay_of(kind, cls.__doc__ or "")

    def setup(self) -> None:
        """Raises FollowspotError that names the missing type."""
        raise FollowspotError(f"{self.context.name} has no type; write uses: recording.port[STAGE.PORT]")

    def process(self) -> Source[Message]:
        """The messages of the port, in order."""
        yield from self.messages(Message)
