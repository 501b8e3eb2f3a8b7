"""The conformance kit: what every stage promises, one function a promise.

A plugin's test calls `check_stage(MyStage)`; built-in stages pass the same checks.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
import pydantic

from followspot.messages import Array, Header, Message, identical, seal, stamped
from followspot.ports import ports
from followspot.room import Room
from followspot.stage import Context, Stage
from followspot.testing.tiny_room import tiny_room
from followspot.tracking import Frame
from followspot.transport.codec import pack, unpack

_HEADER = Header("conformance", 7, 1_000_000_000, 5)
BLACK = np.zeros((48, 64, 3), np.uint8)
"""What the cameras of the tiny room see in the dark."""


class Finding(NamedTuple):
    """A promise that a stage breaks, and what to do."""

    promise: str
    text: str


def check_stage(stage: type[Stage]) -> None:
    """Raise AssertionError with every broken promise of a stage class."""
    found = list(findings(stage))
    assert not found, "\n".join(f"{stage.__name__}: {f.promise}: {f.text}" for f in found)


def findings(stage: type[Stage]) -> Iterator[Finding]:
    """Every broken promise of a stage class."""
    for promise in _PROMISES:
        for text in promise(stage):
            yield Finding(promise.__name__.replace("_", " "), text)


def is_documented(stage: type[Stage]) -> Iterator[str]:
    """The docstring is what `followspot plugins NAME` shows."""
    if not (stage.__doc__ or "").strip() or stage.__doc__ == Stage.__doc__:
        yield "write a docstring that says what the stage does"


def has_readable_ports(stage: type[Stage]) -> Iterator[str]:
    """Ports are read from the signature of `process`; a source is a generator."""
    found = ports(stage)
    if found.source and not inspect.isgeneratorfunction(stage.process):
        yield "process returns Source[...] and does not yield"


def describes_its_parameters(stage: type[Stage]) -> Iterator[str]:
    """Every parameter says what it does; every number says its unit."""
    for name, field in stage.Params.model_fields.items():
        extra = field.json_schema_extra
        unit = extra.get("unit") if isinstance(extra, dict) else None
        if not field.description:
            yield f"parameter {name} has no description"
        if field.annotation in (int, float) and not unit:
            yield f'parameter {name} has no unit; write unit="1" for a plain number'


def has_defaults_within_its_limits(stage: type[Stage]) -> Iterator[str]:
    """What has defaults alone can be built without parameters, and its parameters are JSON."""
    if any(field.is_required() for field in stage.Params.model_fields.values()):
        return
    try:
        json.dumps(stage.Params().model_dump(mode="json"))
    except (pydantic.ValidationError, TypeError) as error:
        yield f"the defaults are refused: {error}"


def refuses_unknown_parameters(stage: type[Stage]) -> Iterator[str]:
    """A misspelt parameter is an error, never ignored."""
    if stage.Params.model_config.get("extra") != "forbid":
        yield "derive Params from followspot.StageParams"


def speaks_messages_that_travel(stage: type[Stage]) -> Iterator[str]:
    """Whatever a stage sends or takes crosses a wire bit for bit."""
    found = ports(stage)
    kinds = ({port.type for port in found.inputs} | {port.type for port in found.outputs}) - {Message}
    for kind in sorted(kinds, key=lambda kind: kind.__name__):
        message = stamped(seal(kind.empty()), _HEADER)
        arrived = unpack(pack(message), kind)
        if not (isinstance(arrived, Message) and identical(arrived, message)):
            yield f"{kind.__name__} does not survive the wire"


def leaves_empty_inputs_alone(stage: type[Stage]) -> Iterator[str]:
    """Empty inputs and black pictures raise nothing; stages that need a parameter are not tried."""
    if not _can_be_tried(stage):
        return
    try:
        with _at_work(stage, tiny_room(), "cam0") as instance, np.errstate(all="raise"):
            instance.process(*_empty_inputs(stage, "cam0", BLACK))
    except Exception as error:
        yield f"empty inputs raise {type(error).__name__}: {str(error).splitlines()[0]}"


def does_together_what_it_does_alone(stage: type[Stage]) -> Iterator[str]:
    """What `process_together` returns is what `process` of each returns, bit for bit, for noise too."""
    if stage.process_together is None or not _can_be_tried(stage):
        return
    room = tiny_room()
    noise = np.random.default_rng(0).integers(0, 256, BLACK.shape, np.uint8)
    try:
        with _at_work(stage, room, "cam0") as one, _at_work(stage, room, "cam1") as other:
            inputs = [_empty_inputs(stage, "cam0", noise), _empty_inputs(stage, "cam1", noise[::-1])]
            alone = [one.process(*inputs[0]), other.process(*inputs[1])]
            together = stage.process_together([one, other], inputs)
        for one_alone, one_together in zip(alone, together, strict=True):
            pairs = zip(_messages(one_alone), _messages(one_together), strict=True)
            if not all(identical(seal(a), seal(b)) for a, b in pairs):
                yield "process_together returns something else than process"
    except Exception as error:
        yield f"together they raise {type(error).__name__}: {str(error).splitlines()[0]}"


def _messages(output: object) -> list[Message]:
    """What goes out of all ports."""
    ports = [output] if output is None or isinstance(output, Message) else vars(output).values()
    return [message for message in ports if message is not None]


def _can_be_tried(stage: type[Stage]) -> bool:
    """Whether it computes something of its inputs, and needs no parameter."""
    found = ports(stage)
    required = any(field.is_required() for field in stage.Params.model_fields.values())
    return bool(found.outputs) and not found.source and not required


@contextmanager
def _at_work(stage: type[Stage], room: Room, camera: str) -> Iterator[Stage]:
    """An instance that is set up, and closed in the end."""
    instance = stage(Context(room=room, camera=room.cameras[camera] if stage.per_camera else None))
    try:
        instance.setup()
        yield instance
    finally:
        instance.close()


def _empty_inputs(stage: type[Stage], camera: str, pixels: Array) -> list[object]:
    """Arguments of `process`: a picture where it takes one, else nothing."""
    return [_empty(port.type, port.kind, camera, pixels) for port in ports(stage).inputs]


def _empty(kind: type[Message], how: str, camera: str, pixels: Array) -> object:
    if how == "latest":
        return None
    message: Message = kind.empty()
    if kind is Frame:
        message = Frame(camera, pixels)
    elif ("camera", str) in kind.scalars:
        object.__setattr__(message, "camera", camera)
    message = stamped(seal(message), _HEADER)
    return (message,) if how == "joined" else message


_PROMISES: tuple[Callable[[type[Stage]], Iterator[str]], ...] = (
    is_documented,
    has_readable_ports,
    describes_its_parameters,
    has_defaults_within_its_limits,
    refuses_unknown_parameters,
    speaks_messages_that_travel,
    leaves_empty_inputs_alone,
    does_together_what_it_does_alone,
)
