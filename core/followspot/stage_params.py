"""Parameters of a stage: their model, their fields, and the types of those that name files and devices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Self, get_args

import pydantic


class PathIn:
    """Marks a parameter that names an existing file or folder, relative to the file it is written in."""


class PathOut:
    """Marks a parameter that names a file to write, below the run's output folder."""


class FolderOut(PathOut):
    """Marks a parameter that names a folder to write into, below the run's output folder."""


class NetworkOut:
    """Marks a parameter that names a receiver in the network: a host, or an address with one in it."""


class DeviceIn:
    """Marks a parameter that names a device, or the address of a stream, to open."""


InputPath = Annotated[Path, PathIn()]
OutputPath = Annotated[Path, PathOut()]
OutputFolder = Annotated[Path, FolderOut()]
OutputHost = Annotated[str, NetworkOut()]
"""Under an agent, a run of an operator elsewhere may send to the agent's host only, unless the owner allows
more."""
InputDevice = Annotated[int | str, DeviceIn()]
InputAddress = Annotated[str, DeviceIn()]
"""Under an agent, a run of an operator elsewhere may open cameras by number only, unless the owner allows
more."""


def Field(default: Any = ..., *, description: str, unit: str = "", **limits: Any) -> Any:  # noqa: N802
    """A parameter: default (none: required), description, unit, and pydantic's limits (gt, ge, lt, le, ...).

    Text, switches and paths have no unit; a plain number says "1".
    """
    return pydantic.Field(default, description=description, json_schema_extra={"unit": unit}, **limits)


ENVELOPE = (
    "uses",
    "each",
    "serves",
    "sees",
    "optional",
    "in",
    "with",
    "on_error",
    "tolerance",
    "deadline",
    "depth",
    "concurrency",
)
"""Keys of every stage in a graph file; its parameters are below `with`."""
LARGEST_INT = (1 << 63) - 1
"""Largest whole number in a parameter; it fits into 64 bits."""
LARGEST = 1e15
SMALLEST = 1e-15
"""Range of the absolute value of other numbers: beyond it, squares and quotients overflow or underflow."""


class StageParams(pydantic.BaseModel):
    """Base of every stage's parameters: immutable, unknown names are errors.

    Beside the limits of each parameter, these hold for all: whole numbers fit into 64 bits, other numbers are
    0 or from `SMALLEST` to `LARGEST` in absolute value, true and false are no numbers, texts contain no NUL,
    and no number `minimum_x` is more than `maximum_x`.
    """

    model_config = pydantic.ConfigDict(
        frozen=True, extra="forbid", validate_default=True, allow_inf_nan=False
    )

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Raise TypeError for a parameter that `--set STAGE.KEY` and `Graph.add` could not mean."""
        taken = next((name for name in cls.model_fields if name in ENVELOPE), None)
        if taken is not None:
            raise TypeError(f'no parameter can be named "{taken}": every stage has a key of that name')

    @pydantic.field_validator("*", mode="before")
    @classmethod
    def _check_switches(cls, value: Any, info: pydantic.ValidationInfo) -> Any:
        """Raises ValueError for true or false in place of a number: pydantic takes them for 1 and 0."""
        types = tuple(_plain_types(cls.model_fields[info.field_name or ""].annotation))
        numbers = any(kind in (int, float) for kind in types)
        if numbers and not any(kind in (bool, Any, object) for kind in types) and _has_switch(value):
            raise ValueError("it must be a number, not true or false")
        return value

    @pydantic.field_validator("*")
    @classmethod
    def _check_values(cls, value: Any) -> Any:
        _check(value)
        return value + 0.0 if isinstance(value, float) else value  # -0.0 is below no limit, and becomes 0.0

    @pydantic.model_validator(mode="after")
    def _check_pairs(self) -> Self:
        """Raises ValueError if `minimum_x` is more than `maximum_x`."""
        values = dict(self)
        for name, least in values.items():
            other = name.replace("minimum_", "maximum_", 1) if name.startswith("minimum_") else ""
            most = values.get(other)
            if _is_number(least) and _is_number(most) and least > most:
                raise ValueError(f"{name} {least:g} is more than {other} {most:g}")
        return self


def _plain_types(annotation: Any) -> Iterator[Any]:
    """The types that an annotation is composed of, such as int and str of ``dict[str, int | None]``."""
    inner = get_args(annotation)
    if not inner:
        yield annotation
    for part in inner:
        yield from _plain_types(part)


def _has_switch(value: Any) -> bool:
    """Whether true or false is in a tree of values."""
    if isinstance(value, Mapping):
        return any(map(_has_switch, value.values()))
    return any(map(_has_switch, value)) if isinstance(value, list | tuple) else isinstance(value, bool)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float)


def _check(value: Any) -> None:
    """Raises ValueError if a number or a text in a tree of values breaks the limits of `StageParams`."""
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
