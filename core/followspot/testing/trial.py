"""Trial of a stage: a room, parameters, instances that are always closed, and inputs."""

from __future__ import annotations

import inspect
import os
import site
import tempfile
import traceback
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pydantic

from followspot.context import Context
from followspot.message_checks.room_fit import fit_check
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, InvalidMessage, Message, stamped
from followspot.ports.signature import ports
from followspot.ports.specs import Ports
from followspot.room import Member, Room
from followspot.stage import Stage
from followspot.testing.samples import BLACK, Content, sample
from followspot.testing.tiny_room import tiny_room

ANSWER = 60.0
"""Longest wait for a deferred answer, s."""
_LIBRARIES = (Path(__file__).parents[1], *map(Path, site.getsitepackages()), Path(os.__file__).parent)
"""Folders of code that is not tried."""
PERIOD = 33_333_333
"""Between two frames, ns."""


@dataclass(frozen=True)
class Trial:
    """One stage class under examination.

    params: for stages that require some; messages: number over which the growth of memory is measured.
    """

    stage: type[Stage]
    params: Mapping[str, Any] = field(default_factory=dict)
    room: Room = field(default_factory=tiny_room)
    messages: int = 2000

    @cached_property
    def ports(self) -> Ports:
        """The stage's ports. Raises SignatureError."""
        return ports(self.stage)

    @property
    def complete(self) -> bool:
        """True if every required parameter is given."""
        fields = self.stage.Params.model_fields
        return all(name in self.params or not info.is_required() for name, info in fields.items())

    @cached_property
    def buildable(self) -> bool:
        """True if its parameters are complete and valid."""
        try:
            self.stage.Params(**self.params)
        except pydantic.ValidationError:
            return False
        return True

    @property
    def computes(self) -> bool:
        """True if it can be called with messages."""
        return self.buildable and not self.ports.source

    @property
    def yields(self) -> bool:
        """True for a source that is no device, and so can be called at any time."""
        generator = inspect.isgeneratorfunction(self.stage.process)
        return self.buildable and self.ports.source and generator and not self.stage.live

    def build(self, out: Path, camera: str | None = None, seed: int = 0) -> Stage:
        """An instance without `setup`; camera: by default the first."""
        name = camera or next(iter(self.room.cameras))
        served = {
            "cameras": name,
            "sensors": next(iter(self.room.sensors), ""),
            "targets": next(iter(self.room.targets), ""),
        }
        chosen = self.stage.serves()
        member = Member(chosen, served[chosen]) if chosen else None
        return self.stage(Context(room=self.room, member=member, out=out, seed=seed), **self.params)

    @contextmanager
    def at_work(self, camera: str | None = None, seed: int = 0) -> Iterator[Stage]:
        """An instance after `setup`, closed at the end of the block; its outputs go to a temporary folder."""
        with tempfile.TemporaryDirectory(prefix="followspot-") as folder:
            instance = self.build(Path(folder), camera, seed)
            try:
                instance.setup()
                yield instance
            finally:
                instance.close()

    def feed(self, stage: Stage, frames: range) -> None:
        """Call `process` with plausible inputs of these frames. Raises what the stage raises."""
        for frame in frames:
            self.called(stage, self.inputs("plausible", frame, noise(frame)))

    def called(self, stage: Stage, inputs: Sequence[Any]) -> Any:
        """The result of `process`: of several results a tuple, of a deferred one the answer."""
        result = stage.process(*inputs)
        if self.ports.gives in ("several", "lagged") and result is not None:
            return tuple(result)
        if self.ports.gives == "later" and result is not None:
            return result.result(ANSWER) if isinstance(result, Future) else result()
        return result

    def seal(self, message: Message) -> None:
        """Seal an output as a port does. Raises InvalidMessage if it breaks its contract or fits no room."""
        seal(message)
        unfit = fit_check(type(message), self.room)
        if unfit is not None and (why := unfit(message)):
            raise InvalidMessage(why)

    def inputs(
        self, content: Content = "empty", frame: int = 0, pixels: Array = BLACK, camera: str | None = None
    ) -> list[Any]:
        """Arguments of `process` for one frame; sampled inputs have no message if the content is empty."""
        name = camera or next(iter(self.room.cameras))
        header = Header("conformance", frame, frame * PERIOD, 5)
        return [
            self._input(port.type, port.kind, content, header, pixels, name) for port in self.ports.inputs
        ]

    def _input(
        self, kind: type[Message], how: str, content: Content, header: Header, pixels: Array, camera: str
    ) -> Any:
        if content == "empty" and how in ("latest", "nearest"):
            return None
        if content == "empty" and how == "window":
            return ()
        made = stamped(seal(sample(kind, content, self.room, camera, pixels, header.seq)), header)
        if how == "window":
            return (stamped(made, header._replace(time=header.time - PERIOD // 2)), made)
        return (made,) if how == "joined" else made


def outputs(output: object) -> list[Message]:
    """The messages that go out of all ports, of each of several results."""
    if isinstance(output, tuple):
        return [message for item in output for message in outputs(item)]
    sent = [output] if isinstance(output, Message) else getattr(output, "__dict__", {}).values()
    return [message for message in sent if isinstance(message, Message)]


def noise(seed: int = 0) -> Array:
    """A picture without any sense, (48, 64, 3) uint8."""
    return np.random.default_rng(seed).integers(0, 256, BLACK.shape, np.uint8)


def reason(error: BaseException) -> str:
    """An exception in one line, with the line of the code that raised it; its own `__str__` may fail."""
    try:
        text = str(error)
    except Exception:
        text = "its text cannot be read"
    return " ".join(f"{type(error).__name__}: {text}".split())[:300] + _raised_at(error)


def _raised_at(error: BaseException) -> str:
    """File and line where the code that is tried raised, or called what raised; "" if there is none."""
    frames = traceback.extract_tb(error.__traceback__)
    files = [(Path(frame.filename), frame.lineno) for frame in frames if not frame.filename.startswith("<")]
    own = [(file, line) for file, line in files if not any(map(file.is_relative_to, _LIBRARIES))]
    return f" ({own[-1][0].name}, line {own[-1][1]})" if own else ""
