"""A recorded port as a source; `followspot_recording.replays` has one for each message type."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar, TypeVar

from followspot import Field, InputPath, Message, Stage, StageParams, at
from followspot.errors import FollowspotError
from followspot.frame_times import to_ns
from followspot_recording.contract import is_of, type_name
from followspot_recording.decoding import decoded
from followspot_recording.recording import Recording

M = TypeVar("M", bound=Message)


class ReplayParams(StageParams):
    """Parameters of every replay."""

    path: InputPath = Field(description="the recording, an MCAP file")
    port: str = Field("", description="recorded port, STAGE.PORT; by default `out` of this stage's name")
    start_time: float = Field(
        0.0, ge=0, unit="s", description="time from the beginning of the recording at which the replay begins"
    )
    stop_time: float | None = Field(
        None, gt=0, unit="s", description="time from the beginning at which the replay ends; none: at its end"
    )
    speed: float = Field(
        0.0, ge=0, le=1000, unit="1", description="speed over that of the recording; 0: as fast as possible"
    )
    loop: bool = Field(
        False, description="whether the replay begins again at the end, with capture times that continue"
    )


class Replay(Stage):
    """Base of the replays. Messages keep their capture times and numbers, bit for bit."""

    Params: ClassVar[Any] = ReplayParams
    params: ReplayParams
    recording: Recording | None = None

    def setup(self) -> None:
        """Open the recording. Raises FollowspotError if it has no such port."""
        self.recording = Recording(self.params.path)
        self.port = self.params.port or f"{self.context.name}.out"
        if self.port not in self.recording.ports:
            have = ", ".join(self.recording.ports) or "none"
            raise FollowspotError(f"{self.params.path} has no port {self.port}; recorded: {have}")

    def length(self) -> int | None:
        """Not known before all is read."""
        return None

    def close(self) -> None:
        """Close the file."""
        if self.recording is not None:
            self.recording.close()

    def messages(self, kind: type[M]) -> Iterator[M]:
        """The messages of the port, paced and looped as the parameters say. Raises FollowspotError."""
        recording, given = self.recording, self.params
        assert recording is not None
        self._check(recording, kind)
        start = recording.begin + to_ns(given.start_time)
        stop = recording.end if given.stop_time is None else recording.begin + to_ns(given.stop_time)
        began = self.context.begun()
        later, round_seqs = 0, 0
        while True:
            last = None
            for message in decoded(recording, self.port, kind, start, stop):
                header = message.header
                moment, number = header.time + later, header.seq + round_seqs
                due = began + round((moment - start) / given.speed) if given.speed else 0
                last = number
                yield at(moment, message, seq=number, due=due)
            if not given.loop or last is None:
                break
            later += _round(start, min(stop, recording.end))
            round_seqs = last + 1
        if recording.problem:
            self.context.warn(recording.problem)

    def _check(self, recording: Recording, kind: type[Message]) -> None:
        """Whether the port holds messages of this type. Raises FollowspotError."""
        channel = recording.ports[self.port]
        if channel.schema != type_name(kind) or not is_of(channel.contract, kind):
            raise FollowspotError(
                f"{recording.path}: {self.port} holds {channel.schema}, and {self.context.name} replays"
                f" {type_name(kind)} of this version; replay it with the followspot that recorded it"
            )


def _round(start: int, stop: int) -> int:
    """Advance of the capture times with each round, ns: the replayed part and a frame interval at 100 Hz."""
    return max(0, stop - start) + 10_000_000
