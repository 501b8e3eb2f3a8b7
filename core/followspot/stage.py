"""The stage: parameters and one `process`, whose signature is the contract.

A stage owns no loop, opens no socket and knows no transport; it can be called like a function::

    class SearchGate(Stage):
        '''Reject blobs outside the circle where their target is expected.'''

        class Params(StageParams):
            scale: float = Field(1.5, gt=0, description="search radius over expected travel", unit="1")

        params: Params

        def process(self, blobs: Blobs, forecast: Latest[Forecast]) -> Blobs: ...

    SearchGate(scale=2.0).process(blobs, forecast)
"""

from __future__ import annotations

import hashlib
import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Protocol, TypeVar

import numpy as np

from followspot.errors import Mistake
from followspot.messages import Array, Message
from followspot.room import SETS, Camera, Member, Room, Sensor, Target
from followspot.stage_params import StageParams

T = TypeVar("T")
SourceLoss = Literal["packet_loss", "device_overrun", "gap"]
"""How a frame of a device is lost before its source has it."""
LOGGER = "followspot.stage"
"""Prefix of the names of the stages' loggers."""


class LatestInput:
    """Marks an input that samples and holds: it never fires."""


class JoinedInput:
    """Marks an input that collects one message from each connected edge."""


class NearestInput:
    """Marks an input that gives the message nearest in time to the firing: it never fires."""


class WindowInput:
    """Marks an input that gives every message since the last firing: it never fires."""


class SeveralOutputs:
    """Marks a result that is several messages for one firing."""


class DeferredOutput:
    """Marks a result that comes later."""


class LaggedOutputs:
    """Marks a result that is messages for earlier firings."""


Latest = Annotated[T | None, LatestInput()]
"""The newest message, or None before the first."""
Joined = Annotated[tuple[T, ...], JoinedInput()]
"""One message per connected camera that has one at this time, in the order of the room's cameras."""
Nearest = Annotated[T | None, NearestInput()]
"""The message nearest in capture time to the firing, before or after it, or None if none lies within the
tolerance of the edge or the stage."""
Window = Annotated[tuple[T, ...], WindowInput()]
"""Every message since the last firing up to the capture time of this one, in the order of capture times."""
Outputs = Annotated[Iterable[T], SeveralOutputs()]
"""Return type of a stage that gives any number of messages for one firing. Their capture times rise, from
that of the firing on: `at(time, message)` says them; the first may leave its time to the runtime."""
Deferred = Annotated[Future[T | None] | Callable[[], T | None] | None, DeferredOutput()]
"""Return type of a stage without a state that answers later: a future, or a function that a thread of the
runtime calls. Answers are sent in the order of the firings, with their capture times; at most as many are
under way as the graph says (`concurrency`, 1 if it says nothing)."""
Lagged = Annotated[Iterable[T], LaggedOutputs()]
"""Return type of a stage that waits for later inputs: messages for firings up to this one, any number for one
firing. Each has the capture time of its firing (`at(time, message)`), and the times rise. `Stage.remaining`
gives those that are left when the inputs have ended."""


def _no_warning(text: str) -> None:
    """Drop the warning: outside a run, none is shown."""


def _no_loss(kind: SourceLoss, number: int) -> None:
    """Count nothing: outside a run there is no ledger."""


def _fresh(shape: tuple[int, ...], dtype: str) -> Array:
    return np.empty(shape, dtype)


def _sleep(seconds: float) -> bool:
    time.sleep(seconds)
    return True


class Post(Protocol):
    """Non-blocking channel from a tap to observers on other hosts."""

    @property
    def wanted(self) -> bool:
        """True if an observer subscribes."""

    def send(self, packet: bytes) -> None:
        """Send a packet, or drop it if the network is congested."""

    def close(self) -> None:
        """Close the channel."""


@dataclass(frozen=True)
class Context:
    """The stage's view of its run. Every field has a default, for tests without a run."""

    name: str = "stage"
    room: Room = Room()
    member: Member | None = None
    """The camera, sensor, target or value of a tag that this instance serves, if the graph says `each`."""
    out: Path = Path()
    """The run's output folder."""
    seed: int = 0
    receives: tuple[type[Message], ...] = ()
    """Types of the messages that the edges bring, each once."""
    warn: Callable[[str], None] = _no_warning
    """Report a problem that does not stop the run; the user sees it with the stage's name, now and at the
    end."""
    loan: Callable[[tuple[int, ...], str], Array] = _fresh
    """An array (shape, dtype) to compute the output into, in shared memory if a reader on this host uses
    it."""
    pause: Callable[[float], bool] = _sleep
    """Wait (s), for a live source, which has a thread of its own. Returns False at once if the run is ending:
    the source should return then. With another source its whole worker waits: it says when a message is due
    (`at`)."""
    resumed: bool = False
    """True if an earlier instance of the stage has worked in this run: a sink keeps what that one wrote."""
    lost: Callable[[SourceLoss, int], None] = _no_loss
    """Count frames that the device made and that did not come, for a live source: with packets missing
    (`packet_loss`), given up because they were not taken in time (`device_overrun`), or left out in the
    numbers of the frames (`gap`). The ledger shows them as lost at the source."""
    run_begun: Callable[[], int] = time.monotonic_ns
    """When the stages of this host began together, ns of `time.monotonic_ns`."""
    post: Post | None = None
    """Channel to the observers of a tap on another host than the operator's."""

    def begun(self) -> int:
        """Since when a source that plays at a pace counts, ns of `time.monotonic_ns`.

        That is when all sources of this host began, in whichever workers they are; for one that comes later
        (`resumed`) it is now.
        """
        return time.monotonic_ns() if self.resumed else self.run_begun()

    @classmethod
    def serving(cls, camera: Camera, room: Room | None = None, **rest: Any) -> Context:
        """The context of an instance that serves a camera; without a room, in one of that camera alone."""
        found = Room(cameras={camera.name: camera}) if room is None else room
        return cls(room=found, member=Member("cameras", camera.name), **rest)


class Stage:
    """Base of all stages. Subclasses declare `Params` and `process`; the rest is optional."""

    class Params(StageParams):
        """No parameters."""

    live: ClassVar[bool] = False
    """True for a source that delivers at its own pace (a device); such a source drops its oldest frame if it
    must."""
    per_camera: ClassVar[bool] = False
    """True if an instance serves exactly one camera (`self.camera`)."""
    per_sensor: ClassVar[bool] = False
    """True if an instance serves exactly one sensor (`self.sensor`)."""
    per_target: ClassVar[bool] = False
    """True if an instance serves exactly one target (`self.target`)."""
    by_kind: ClassVar[Mapping[str, str]] = {}
    """For a source of cameras: the stage that takes its place for a camera of that kind, as
    `{"depth": "sim.depth_camera"}`, because it gives messages of another type."""
    tap: ClassVar[bool] = False
    """True for a sink that other programs may put at a port of a running graph. It sends to observers of the
    run only."""

    table_path: ClassVar[str] = ""
    """The parameter of a sink that names the CSV file in which it writes the tables of its messages: tracks
    and poses in it are scored if the room has ground truth."""

    advice: ClassVar[str] = ""
    """What helps if the stage gets messages and never gives one with rows; the summary of such a run shows
    it."""

    join_tolerance: ClassVar[float] = 0.004
    """Largest difference in capture time of messages that fire together, s, unless the graph says another.
    With 0 only equal times fire together, so that no message lacks a partner: for stages that take each
    message by itself, as files do."""

    state_lacks: ClassVar[str] = ""
    """What `state` leaves out because it is too large to travel, as pictures are; "" for nothing. A successor
    carries on without it and gives other results at first, and `followspot verify` repeats the stage from its
    first message only."""

    process_together: ClassVar[Callable[..., Any] | None] = None
    """Optional batch version of `process`: a classmethod `(stages, inputs) -> outputs`.

    stages: instances of this class with the same parameters in one room; inputs: the arguments of `process`
    for each; outputs: the results of `process` for each, bit for bit, in the same order. A worker calls it
    with any subset of the instances that are ready at once. If it raises, the worker calls `process` of each
    instead, so it must not change the stages before it raises.
    """

    for_type: ClassVar[Callable[..., Any] | None] = None
    """Optional, for a stage that serves any message type: a classmethod `(kind) -> class` for one type.

    A graph names the type by a port that sends it: `uses: NAME[STAGE.PORT]`.
    """

    params: Any
    process: Callable[..., Any]

    @classmethod
    def serves(cls) -> str:
        """The set of the room of which an instance serves exactly one member, "" if it may serve none."""
        marks = {"cameras": cls.per_camera, "sensors": cls.per_sensor, "targets": cls.per_target}
        return next((name for name, marked in marks.items() if marked), "")

    def __init__(self, context: Context = Context(), /, **params: Any) -> None:
        """context: of the run; params: values for `Params`. Raises pydantic.ValidationError."""
        self.context = context
        self.params = self.Params(**params)

    @property
    def room(self) -> Room:
        """The calibrated room."""
        return self.context.room

    @cached_property
    def camera(self) -> Camera:
        """The camera that this instance serves. Raises LookupError if it serves none."""
        return self.room.cameras[self._served("cameras")]

    @cached_property
    def sensor(self) -> Sensor:
        """The sensor that this instance serves. Raises LookupError if it serves none."""
        return self.room.sensors[self._served("sensors")]

    @cached_property
    def target(self) -> Target:
        """The target that this instance serves. Raises LookupError if it serves none."""
        return self.room.targets[self._served("targets")]

    def _served(self, members: str) -> str:
        """Name of the member of a set that this instance serves. Raises LookupError if it serves none."""
        member, noun = self.context.member, SETS[members]
        if member is None or member.set != members:
            raise LookupError(f'{self.context.name} serves no {noun}: give it one with "each: {members}"')
        if member.name not in getattr(self.room, members):
            raise LookupError(f'{self.context.name} serves {member}, which the room "{self.room.name}" lacks')
        return member.name

    @cached_property
    def rng(self) -> np.random.Generator:
        """Random generator seeded by the run's seed and the stage's name: the same in every placement."""
        digest = hashlib.sha256(f"{self.context.seed}:{self.context.name}".encode()).digest()
        return np.random.default_rng(int.from_bytes(digest[:8], "little"))

    @cached_property
    def log(self) -> logging.Logger:
        """Logger of this instance; `followspot logs` shows its records from level info on."""
        return logging.getLogger(f"{LOGGER}.{self.context.name}")

    @classmethod
    def nominal_rate(cls, params: Any) -> float | None:
        """Messages per second, Hz, that a source gives with these parameters (of `Params`); None if unknown.

        A live source above 100 Hz keeps half a second of messages for a graph that is busy, any other two.
        """
        return None

    @classmethod
    def check_room(cls, params: Any, room: Room, cameras: Sequence[Camera]) -> Iterable[Mistake]:
        """Reasons known before a run why the stage can find nothing in a room; they become warnings.

        params: of its first instance; cameras: those whose messages reach any of its instances. A mistake
        without a place gets that of the stage.
        """
        return ()

    @classmethod
    def check_files(cls, params: Any, room: Room, member: Member | None) -> Iterable[Mistake]:
        """Mistakes of the files and members of the room that `params` names, as far as is found at once.

        Of a table the first rows are read; a run reads the whole in `setup`. member: that the instance
        serves. A mistake in a file has its place there; a text that begins with "PARAMETER: " is about the
        value of that parameter. One with `warning` does not stop the run. InputError may be raised instead.
        """
        return ()

    def setup(self) -> None:
        """Open files and devices; the worker calls it once before the first message."""

    def length(self) -> int | None:
        """Number of messages that a source will yield, if known after `setup`; for progress only."""
        return None

    def capture_time(self, number: int) -> int | None:
        """Capture time of the message of this number, from 0, of a source, ns, if known after `setup`.

        A run of N frames ends its sensors at that of the last frame; without it, soon after the last frame.
        """
        return None

    def remaining(self) -> Iterable[Any]:
        """The messages that a stage which lags (`Lagged`) still owes after its last input; called once."""
        return ()

    def close(self) -> None:
        """Complete the outputs; the worker calls it once after the last message, also after an error."""

    def state(self) -> Any:
        """Checkpoint for a replacement: numbers, text, arrays, lists and dicts; None for none.

        :func:`followspot.plain_values.to_plain` makes it of dataclasses and named tuples.
        """
        return None

    def restore(self, state: Any) -> None:
        """Carry on from the checkpoint that `state` of another instance gave; the worker calls it after
        `setup`.

        If a swap takes a moment, the worker calls it again with a newer checkpoint before the first message.
        """


Source = Iterator
"""Return type of a source's `process`: a generator of messages made with :func:`followspot.at`."""
