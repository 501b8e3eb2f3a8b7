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
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Protocol, TypeVar

import numpy as np
import pydantic

from followspot.messages import Array
from followspot.room import Camera, Room

T = TypeVar("T")
LOGGER = "followspot.stage"
"""What the names of the loggers of stages begin with."""


class LatestInput:
    """Marks an input that samples and holds: it never fires."""


class JoinedInput:
    """Marks an input that collects one message from each connected edge."""


class PathIn:
    """Marks a parameter that names an existing file or folder, relative to the file it is written in."""


class PathOut:
    """Marks a parameter that names a file to write, below the run's output folder."""


class NetworkOut:
    """Marks a parameter that names a receiver in the network: a host, or an address with one in it."""


class DeviceIn:
    """Marks a parameter that names a device, or the address of a stream, to open."""


Latest = Annotated[T | None, LatestInput()]
"""The newest message, or None before the first."""
Joined = Annotated[tuple[T, ...], JoinedInput()]
"""One message per connected camera that has one at this time, in the order of the room's cameras."""
InputPath = Annotated[Path, PathIn()]
OutputPath = Annotated[Path, PathOut()]
OutputHost = Annotated[str, NetworkOut()]
"""An agent lets orders from elsewhere send to its own host alone, unless its owner allows more."""
InputDevice = Annotated[int | str, DeviceIn()]
InputAddress = Annotated[str, DeviceIn()]
"""An agent lets orders from elsewhere open cameras by number alone, unless its owner allows more."""


def Field(default: Any = ..., *, description: str, unit: str = "", **limits: Any) -> Any:  # noqa: N802
    """A parameter: default (none: required), description, unit, and pydantic's limits (gt, ge, lt, le, ...).

    Text, switches and paths have no unit; a plain number says "1".
    """
    return pydantic.Field(default, description=description, json_schema_extra={"unit": unit}, **limits)


LARGEST_INT = (1 << 63) - 1
"""Largest whole number in a parameter; it fits into 64 bits."""
LARGEST = 1e15
SMALLEST = 1e-15
"""Of other numbers, without their sign: beyond, squares and quotients leave the range of floats."""


class StageParams(pydantic.BaseModel):
    """Base of every stage's parameters: immutable, unknown names are errors.

    Whatever their own limits, whole numbers fit into 64 bits, others are 0 or from `SMALLEST` to `LARGEST`,
    and no text contains a NUL.
    """

    model_config = pydantic.ConfigDict(
        frozen=True, extra="forbid", validate_default=True, allow_inf_nan=False
    )

    @pydantic.field_validator("*")
    @classmethod
    def _check_values(cls, value: Any) -> Any:
        _check(value)
        return value + 0.0 if isinstance(value, float) else value  # -0.0 is below no limit, and becomes 0.0


def _check(value: Any) -> None:
    """Raises ValueError if a number or a text in a tree of values is beyond all reason."""
    if isinstance(value, Mapping):
        _check(list(value.values()))
    elif isinstance(value, list | tuple | set | frozenset):
        for item in value:
            _check(item)
    elif isinstance(value, str | Path):
        if "\0" in str(value):
            raise ValueError("a text must not contain a NUL")
    elif isinstance(value, int):
        if abs(value) > LARGEST_INT:
            raise ValueError("a whole number must fit into 64 bits")
    elif isinstance(value, float) and value and not SMALLEST <= abs(value) <= LARGEST:
        raise ValueError(f"a number must be 0 or from {SMALLEST:g} to {LARGEST:g}")


def _no_warning(text: str) -> None:
    """Outside a run there is nobody to warn."""


def _fresh(shape: tuple[int, ...], dtype: str) -> Array:
    return np.empty(shape, dtype)


def _sleep(seconds: float) -> bool:
    time.sleep(seconds)
    return True


class Post(Protocol):
    """The way to those who look at a graph from other hosts; it never waits."""

    @property
    def wanted(self) -> bool:
        """Whether anybody takes what is sent."""

    def send(self, packet: bytes) -> None:
        """Send, or drop where the network is full."""

    def close(self) -> None:
        """Send no more."""


@dataclass(frozen=True)
class Context:
    """What a stage may know of the run that it is part of; every part has a default for tests."""

    name: str = "stage"
    room: Room = Room()
    camera: Camera | None = None
    """The camera that this instance serves, where the graph says `each: cameras`."""
    out: Path = Path()
    """The run's output folder."""
    seed: int = 0
    warn: Callable[[str], None] = _no_warning
    """Tell the user what does not stop the run; shown with the stage's name, at once and at the end."""
    loan: Callable[[tuple[int, ...], str], Array] = _fresh
    """An array (shape, dtype) to compute the output into, in shared memory where a reader is near."""
    pause: Callable[[float], bool] = _sleep
    """Wait so many seconds: for a source that keeps a pace of its own. It returns at once, with False, when
    the run is to end: the source then ends, too. Where messages are only read for a table nobody waits."""
    post: Post | None = None
    """Of a tap on another host than the operator's: the way to those who look on."""


class Stage:
    """Base of all stages. Subclasses declare `Params` and `process`; the rest is optional."""

    class Params(StageParams):
        """No parameters."""

    live: ClassVar[bool] = False
    """Whether a source delivers in its own time (a device); live sources drop their oldest frame."""
    per_camera: ClassVar[bool] = False
    """Whether an instance serves exactly one camera (`self.camera`)."""
    tap: ClassVar[bool] = False
    """Whether a sink may be put at a port of a graph that runs, from outside: it tells those who look on, and
    nobody else."""

    process_together: ClassVar[Callable[..., Any] | None] = None
    """Optional: what `process` of several stages would return, bit for bit, for less than one by one.

    A classmethod `(stages, inputs) -> outputs`: stages of this class with the same parameters in one room,
    the arguments that each one's `process` would get, and what each would return, in the same order. A worker
    calls it where several are ready at once; it may not rely on who they are. Where it raises, `process` of
    each is called, so it must leave the stages as they were.
    """

    for_type: ClassVar[Callable[..., Any] | None] = None
    """Optional, of a stage that serves any message type: a classmethod `(kind) -> class`, the one for it.

    A graph asks for it by a port that has the type: `uses: NAME[STAGE.PORT]`.
    """

    params: Any
    process: Callable[..., Any]

    def __init__(self, context: Context = Context(), /, **params: Any) -> None:
        """context: of the run; params: values of `Params`, validated. Raises pydantic.ValidationError."""
        self.context = context
        self.params = self.Params(**params)

    @property
    def room(self) -> Room:
        """The calibrated room."""
        return self.context.room

    @property
    def camera(self) -> Camera:
        """The camera that this instance serves. Raises LookupError where there is none."""
        if self.context.camera is None:
            raise LookupError(f'{self.context.name} serves no camera: give it one with "each: cameras"')
        return self.context.camera

    @cached_property
    def rng(self) -> np.random.Generator:
        """Random numbers of this instance: the same in every placement, set by the run's seed."""
        digest = hashlib.sha256(f"{self.context.seed}:{self.context.name}".encode()).digest()
        return np.random.default_rng(int.from_bytes(digest[:8], "little"))

    @cached_property
    def log(self) -> logging.Logger:
        """Python's logger of this instance; `followspot logs` shows what it says from level info on."""
        return logging.getLogger(f"{LOGGER}.{self.context.name}")

    def setup(self) -> None:
        """Called once before the first message, in the worker; open files and devices here."""

    def length(self) -> int | None:
        """How many messages a source will yield, where it knows; asked after `setup`, for progress only."""
        return None

    def close(self) -> None:
        """Called once after the last message, also after an error; outputs must be complete then."""

    def state(self) -> Any:
        """What a successor needs to carry on: numbers, text, arrays, lists and dicts; None for nothing."""
        return None

    def restore(self, state: Any) -> None:
        """Carry on from what `state` of a predecessor gave; called after `setup`.

        Where a swap takes a moment, it is called again with a newer state before the first message.
        """


Source = Iterator
"""Return type of a source's `process`: a generator of messages made with :func:`followspot.at`."""
