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
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from followspot.context import Context
from followspot.errors import Mistake
from followspot.room import SETS, Camera, Member, Room, Sensor, Target
from followspot.stage_params import StageParams

LOGGER = "followspot.stage"
"""Prefix of the names of the stages' loggers."""


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
    """For a source of cameras: the stages that take its place for cameras of other kinds, because they give
    messages of another type: `{"depth": "sim.depth_camera"}`."""
    tap: ClassVar[bool] = False
    """True for a sink that other programs may put at a port of a running graph. It sends to observers of the
    run only."""

    table_path: ClassVar[str] = ""
    """The parameter of a sink that names the CSV file in which it writes the tables of its messages: tracks
    and poses in it are scored if the room has ground truth."""

    advice: ClassVar[str] = ""
    """Advice in the summary of a run in which the stage got messages and never gave one with rows."""

    join_tolerance: ClassVar[float] = 0.004
    """Largest difference in capture time of messages that fire together, s, unless the graph says another.
    With 0 only equal times fire together, so that no message lacks a partner: for stages that take each
    message by itself, as files do."""

    state_lacks: ClassVar[str] = ""
    """What `state` leaves out because it is too large to travel, for example pictures; "" for nothing. A
    replacement carries on without it and gives other results at first, and `followspot verify` can repeat the
    stage from its first message only."""

    process_together: ClassVar[Callable[..., Any] | None] = None
    """Optional batch version of `process`: a classmethod `(stages, inputs) -> outputs`.

    stages: instances of this class with the same parameters that know the same cameras of the room; inputs:
    the arguments of `process` for each; outputs: the results of `process` for each, bit for bit, in the same
    order. A worker calls it with any subset of the instances that are ready at once. If it raises, the worker
    calls `process` of each instead, so it must not change the stages before it raises.
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

        A live source above 100 Hz keeps half a second of messages while the graph is busy; a slower one keeps
        two messages.
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
        """Complete the outputs, after the last message or an error.

        It may be called without `setup`, or twice. For a live source it is called in another thread while
        `process` may still wait for the device. What `process` raises from then on does not fail the run: an
        error of a wait for a closed file, socket or device goes to the log, any other one is a warning.
        """

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
