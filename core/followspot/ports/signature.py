"""The ports of a stage, read from the signature of its `process`."""

from __future__ import annotations

import dataclasses
import inspect
import types
import typing
from collections.abc import Callable
from functools import cache
from typing import Any, get_args, get_origin

from followspot.errors import FollowspotError
from followspot.messages import Message
from followspot.ports.marks import (
    DeferredMark,
    JoinedMark,
    LaggedMark,
    LatestMark,
    NearestMark,
    OutputsMark,
    Source,
    WindowMark,
)
from followspot.ports.specs import ONE_OUTPUT, SEVERAL, Giving, InputKind, InputSpec, OutputSpec, Ports
from followspot.stage import Stage
from followspot.stage_params import StageParams

_MARKS: dict[type, InputKind] = {
    LatestMark: "latest",
    JoinedMark: "joined",
    NearestMark: "nearest",
    WindowMark: "window",
}
_GIVING: dict[type, Giving] = {OutputsMark: "several", DeferredMark: "later", LaggedMark: "lagged"}


class SignatureError(FollowspotError):
    """The signature of `process` does not declare the ports; the text says what to write."""


def ports(stage: type[Stage]) -> Ports:
    """Read the ports. Raises SignatureError."""
    return _ports(typing.cast(Any, stage))  # classes are hashable


@cache
def _ports(stage: Any) -> Ports:
    """See `ports`."""
    process = getattr(stage, "process", None)
    if not inspect.isfunction(process):
        raise SignatureError(f"{stage.__name__} has no method `process`: define process(self, ...) -> ...")
    _check_callable(stage, process)
    hints = _hints(stage, process)
    signature = inspect.signature(process)
    inputs = tuple(_input(stage, p, hints) for p in list(signature.parameters.values())[1:])
    if "return" not in hints:
        raise SignatureError(f"{stage.__name__}.process says not what it returns: write `-> None` for a sink")
    returned = hints["return"]
    source = get_origin(returned) is get_origin(Source[Any])
    if source and inputs:
        raise SignatureError(f"{stage.__name__}.process yields and has inputs; a source has none")
    if not source and not inputs:
        raise SignatureError(f"{stage.__name__}.process has no inputs: a source returns Source[MessageType]")
    if inputs and not any(port.fires for port in inputs):
        raise SignatureError(
            f"{stage.__name__}.process has sampled inputs only, so it would never fire;"
            " declare the one for whose messages it is to fire as MessageType or Joined[MessageType]"
        )
    gives, returned = _giving(stage, get_args(returned)[0] if source else returned)
    if gives == "one" and not source and inspect.isgeneratorfunction(process):
        raise SignatureError(
            f"{stage.__name__}.process yields: return the message, or declare Outputs[MessageType]"
        )
    if gives != "one" and source:
        raise SignatureError(f"{stage.__name__}.process yields already: a source returns Source[MessageType]")
    return Ports(inputs, _outputs(stage, returned), source, gives)


def _check_callable(stage: type[Stage], process: Callable[..., Any]) -> None:
    """Raises SignatureError unless the runtime can call `process` of a stage with inputs alone."""
    if not issubclass(stage, Stage):
        raise SignatureError(f"{stage.__name__} is no stage: write class {stage.__name__}(Stage)")
    own = next(iter(inspect.signature(process).parameters.values()), None)
    if own is None or (own.name != "self" and own.annotation is not own.empty):
        raise SignatureError(f"{stage.__name__}.process has no self: define process(self, ...) -> ...")
    if inspect.iscoroutinefunction(process) or inspect.isasyncgenfunction(process):
        raise SignatureError(
            f"{stage.__name__}.process is async: write `def process`, and return Deferred[MessageType] for"
            " what takes long"
        )


def check_init(stage: type[Stage]) -> None:
    """Raises SignatureError unless the runtime can make the stage, which it gives context and parameters."""
    if not issubclass(stage.Params, StageParams):
        raise SignatureError(f"{stage.__name__}.Params is no StageParams: write class Params(StageParams)")
    try:
        inspect.signature(stage.__init__).bind(None, None)
    except TypeError:
        raise SignatureError(
            f"{stage.__name__}.__init__ takes no context: prepare in setup(self) what the stage keeps"
        ) from None


def gives_always(stage: type[Stage]) -> bool:
    """Whether `process` declares a message for each firing: it returns a type, and no `| None`."""
    returned = _hints(stage, stage.process).get("return")
    return isinstance(returned, type) and returned is not types.NoneType


def _hints(stage: type[Stage], process: Callable[..., Any]) -> dict[str, Any]:
    """Types of the parameters and of the result of `process`. Raises SignatureError."""
    try:
        return typing.get_type_hints(process, include_extras=True)
    except (NameError, TypeError, AttributeError) as error:
        raise SignatureError(
            f"{stage.__name__}.process has an annotation that cannot be read: {error}"
        ) from error


def _input(stage: type[Stage], parameter: inspect.Parameter, hints: dict[str, Any]) -> InputSpec:
    """The input that a parameter of `process` declares. Raises SignatureError."""
    name = parameter.name
    if parameter.kind not in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD):
        raise SignatureError(
            f"{stage.__name__}.process: {name} cannot be a port; name each input, without * and **"
        )
    if name not in hints:
        raise SignatureError(f"{stage.__name__}.process: input {name} has no type; write {name}: MessageType")
    hint = hints[name]
    kind: InputKind = "plain"
    for mark in getattr(hint, "__metadata__", ()):
        kind = _MARKS.get(type(mark), kind)
    if get_origin(hint) is typing.Annotated:
        hint = get_args(hint)[0]
    if kind in SEVERAL:
        hint = get_args(hint)[0]
    found = _message(hint)
    if found is None:
        raise SignatureError(
            f"{stage.__name__}.process: input {name} is no message type;"
            f" write {name}: MessageType, or MessageType in Joined, Latest, Nearest or Window"
        )
    required, uniform = parameter.default is parameter.empty, isinstance(hint, typing.TypeVar)
    return InputSpec(name, found, kind, required, uniform)


def _giving(stage: type[Stage], returned: Any) -> tuple[Giving, Any]:
    """The kind of a stage's result, and the type within `Outputs`, `Deferred` or `Lagged`."""
    marks = [_GIVING[type(mark)] for mark in getattr(returned, "__metadata__", ()) if type(mark) in _GIVING]
    if not marks:
        return "one", returned
    (gives,) = marks
    if gives == "later" and stage.state is not Stage.state:
        raise SignatureError(
            f"{stage.__name__} answers later and defines state(): what it keeps would depend on when answers"
            " come; keep nothing, or return the message itself"
        )
    if stage.process_together is not None:
        raise SignatureError(
            f"{stage.__name__} defines process_together, which needs one message for each firing"
        )
    inner = get_args(returned)[0]
    return gives, get_args(get_args(inner)[0] if gives == "later" else inner)[0]


def _outputs(stage: type[Stage], returned: Any) -> tuple[OutputSpec, ...]:
    """The outputs that a return type, within `Source` or `Outputs`, declares. Raises SignatureError."""
    if returned is types.NoneType:
        return ()
    message = _message(returned)
    if message is not None:
        return (_output(stage, ONE_OUTPUT, message),)
    several = _optional(returned)
    if dataclasses.is_dataclass(several):
        hints = typing.get_type_hints(several)
        found = [(f.name, _message(hints[f.name])) for f in dataclasses.fields(several)]
        if found and all(kind is not None for _, kind in found):
            return tuple(_output(stage, name, kind) for name, kind in found if kind is not None)
    raise SignatureError(
        f"{stage.__name__}.process returns {returned!r}: return a message type, a dataclass of message types,"
        " Source[...], Outputs[...], Deferred[...] or Lagged[...] of either, or None"
    )


def _output(stage: type[Stage], name: str, kind: type[Message]) -> OutputSpec:
    """An output of exactly this type. Raises SignatureError if it is the base of all messages."""
    if kind is Message and stage.for_type is None:
        raise SignatureError(
            f"{stage.__name__}.process returns Message, the base of all messages: return the type"
            " that it sends"
        )
    return OutputSpec(name, kind)


def _message(hint: Any) -> type[Message] | None:
    """The message type behind `T`, `T | None` or a type variable with such a bound."""
    hint = _optional(hint)
    hint = hint.__bound__ if isinstance(hint, typing.TypeVar) else hint
    return hint if isinstance(hint, type) and issubclass(hint, Message) else None


def _optional(hint: Any) -> Any:
    """`T` for `T | None`, else the hint itself."""
    if get_origin(hint) in (types.UnionType, typing.Union):
        rest = [arg for arg in get_args(hint) if arg is not types.NoneType]
        return rest[0] if len(rest) == 1 else hint
    return hint
