"""The conformance kit: what every stage promises, one function a promise.

A plugin's test calls `check_stage(MyStage)`; built-in stages pass the same checks.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import pydantic

from followspot.messages import Header, Message, identical, seal, stamped
from followspot.ports import ports
from followspot.stage import Context, Stage
from followspot.testing.tiny_room import tiny_room
from followspot.tracking import Frame
from followspot.transport.codec import pack, unpack

_HEADER = Header("conformance", 7, 1_000_000_000, 5)


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
    found = ports(stage)
    required = any(field.is_required() for field in stage.Params.model_fields.values())
    if found.source or not found.outputs or required:
        return
    room = tiny_room()
    instance = None
    try:
        instance = stage(Context(room=room, camera=room.cameras["cam0"] if stage.per_camera else None))
        instance.setup()
        arguments = [_empty(port.type, port.kind) for port in found.inputs]
        with np.errstate(all="raise"):
            instance.process(*arguments)
    except Exception as error:
        yield f"empty inputs raise {type(error).__name__}: {str(error).splitlines()[0]}"
    finally:
        if instance is not None:
            instance.close()


def _empty(kind: type[Message], how: str) -> object:
    if how == "latest":
        return None
    message: Message = kind.empty()
    if kind is Frame:
        message = Frame("cam0", np.zeros((48, 64, 3), np.uint8))
    elif ("camera", str) in kind.scalars:
        object.__setattr__(message, "camera", "cam0")
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
)
