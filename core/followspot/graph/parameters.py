"""A stage's parameters, checked by its own model, with mistakes at the place of the value."""

from __future__ import annotations

import os
import stat
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import Any, get_args

import pydantic
from pydantic.fields import FieldInfo
from pydantic_core import PydanticSerializationError

from followspot.errors import Mistake, Place, did_you_mean
from followspot.plugins.former_names import new_names
from followspot.stage import Stage
from followspot.stage_params import FolderOut, PathIn, PathOut, StageParams
from followspot.yaml.node import Node, plain

_PROBLEMS = {
    **dict.fromkeys(("float_parsing", "float_type"), "it must be a number"),
    **dict.fromkeys(("int_parsing", "int_type", "int_from_float"), "it must be a whole number"),
    **dict.fromkeys(("bool_parsing", "bool_type"), "it must be true or false"),
    **dict.fromkeys(("list_type", "tuple_type"), "it must be a list"),
    "dict_type": "it must be a mapping of keys to values",
    "string_type": "it must be text",
    "path_type": "it must be a path",
}
"""Texts for pydantic's kinds of type errors, in words of YAML files instead of Python."""
_LONGEST_NAME = 255
"""Longest name of a file that a file system takes, bytes."""
_OPTION = "--"
"""Places on the command line begin with it; paths written there are relative to the working folder."""


def validated(
    stage: type[Stage],
    noun: str,
    params: Mapping[str, Node],
    place: Place,
    mistakes: list[Mistake],
    *,
    given: Mapping[str, Any] = MappingProxyType({}),
    folder: Path = Path(),
) -> dict[str, Any] | None:
    """Parameters with their defaults in JSON types, input paths absolute; None if a mistake was noted.

    noun: describes the stage, as in 'stage "fuse" (balls.mean)'; place: of mistakes about missing parameters;
    given: checked values for parameters that are not named; folder: that paths on the command line are
    relative to.
    """
    before = len(mistakes)
    fields = stage.Params.model_fields
    values = {name: _value(fields.get(name), name, node, mistakes, folder) for name, node in params.items()}
    try:
        model = stage.Params.model_validate({**given, **values})
    except pydantic.ValidationError as error:
        mistakes += [_mistake(detail, stage, noun, params, place) for detail in error.errors()]
        return None
    if len(mistakes) > before:
        return None
    try:
        return model.model_dump(mode="json")
    except (PydanticSerializationError, UnicodeError):  # a default of any type, such as a function
        mistakes += [_unwritable(n, noun, params.get(n), place) for n in fields if not _is_written(model, n)]
        return None


def output_paths(params: type[StageParams], values: Mapping[str, Any]) -> list[str]:
    """The files and folders that a stage with these values writes, relative to the output folder."""
    return _paths(path_parameters(params, PathOut), values)


def output_files(params: type[StageParams], values: Mapping[str, Any]) -> list[str]:
    """Those of `output_paths` that are files."""
    folders = path_parameters(params, FolderOut)
    return _paths([name for name in path_parameters(params, PathOut) if name not in folders], values)


def _paths(names: Sequence[str], values: Mapping[str, Any]) -> list[str]:
    return [str(PurePath(values[name])) for name in names if values[name] is not None]


def plain_default(stage: type[Stage], name: str) -> Any:
    """A default in JSON types."""
    default = stage.Params.model_fields[name].get_default(call_default_factory=True)
    return stage.Params.model_construct(**{name: default}).model_dump(mode="json", warnings=False)[name]


def path_parameters(params: type[StageParams], mark: type) -> list[str]:
    """Names of the parameters with this mark: PathIn, PathOut, FolderOut, NetworkOut or DeviceIn."""
    return [name for name, info in params.model_fields.items() if _marked(info, mark)]


def _value(info: FieldInfo | None, name: str, node: Node, mistakes: list[Mistake], folder: Path) -> Any:
    """The plain value; paths are checked and input paths made absolute."""
    value = plain(node)
    if info is None or not isinstance(value, str):
        return value
    if _marked(info, PathIn):
        file = node.place.file
        path = (folder if file.startswith(_OPTION) else Path(file).parent) / value
        if not value:
            mistakes.append(Mistake(node.place, f'"{name}" names no file: the path is empty', "write a path"))
        elif problem := _unfit(path):
            remedy = "paths are relative to the file that they are written in"
            mistakes.append(Mistake(node.place, f'"{name}" names {path!s}, which {problem}', remedy))
        return str(path.absolute())
    if _marked(info, PathOut):
        output = PurePath(value)
        if output.is_absolute() or ".." in output.parts or not output.parts or "\0" in value:
            text = f'"{name}" names {value!r}, which is not below the output folder'
            mistakes.append(Mistake(node.place, text, "write a relative path without .."))
        elif any(len(os.fsencode(part)) > _LONGEST_NAME for part in output.parts):
            text = f'"{name}" names a file with more than {_LONGEST_NAME} bytes in its name'
            mistakes.append(Mistake(node.place, text, "write a shorter one"))
    return value


def _unfit(path: Path) -> str:
    """Why a path is no input; empty for a file and for a folder."""
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return "does not exist"
    except OSError as error:
        return f"cannot be read: {error.strerror}"
    return "" if stat.S_ISREG(mode) or stat.S_ISDIR(mode) else "is neither a file nor a folder"


def _marked(info: FieldInfo, mark: type) -> bool:
    """True if a parameter is declared with the mark, also as `InputPath | None`."""
    return any(isinstance(found, mark) for found in (*info.metadata, *_marks(info.annotation)))


def _marks(annotation: Any) -> list[Any]:
    inner = [mark for argument in get_args(annotation) for mark in _marks(argument)]
    return [*getattr(annotation, "__metadata__", ()), *inner]


def _mistake(detail: Any, stage: type[Stage], noun: str, params: Mapping[str, Node], place: Place) -> Mistake:
    """A mistake from pydantic, at the place of the value or the key."""
    fields = stage.Params.model_fields
    location: Sequence[int | str] = detail["loc"]
    kind: str = detail["type"]
    name = ".".join(str(part) for part in location) or "parameters"
    top = str(location[0]) if location else ""
    node = _find(params, location)
    if kind == "missing":
        about = _about(fields.get(top))
        missing = f'{noun} needs the parameter "{name}"'
        return Mistake(node.key if node is not None else place, missing, f"add with: {{{name}: ...}}{about}")
    if kind == "extra_forbidden" and node is not None:
        word = new_names(stage).get(name, name)
        known = did_you_mean(word, fields, "parameters") if len(location) == 1 else "remove it"
        return Mistake(node.key, f'{noun} has no parameter "{name}"', known)
    problem = _PROBLEMS.get(kind) or _in_short(str(detail["msg"]))
    if not location:  # values that do not go together
        one = next((value for key, value in params.items() if key in problem.split()), None)
        return Mistake(one.place if one is not None else place, f"{noun} cannot be so: {problem}")
    value = detail["input"]
    given = "nothing" if value is None else repr(value) if isinstance(value, str | int | float) else "this"
    text = f'"{name}" of {noun} cannot be {given}: {problem}'
    return Mistake(node.place if node is not None else place, text, _about(fields.get(top)).lstrip(", "))


def _in_short(message: str) -> str:
    """A message of pydantic, as a sentence about the value."""
    return message.replace("Input should", "it must").replace("Value error, ", "")


def _is_written(model: StageParams, name: str) -> bool:
    """Whether a parameter can be written as JSON, in which it travels to a worker."""
    try:
        model.model_dump(mode="json", include={name})
    except (PydanticSerializationError, UnicodeError):
        return False
    return True


def _unwritable(name: str, noun: str, node: Node | None, place: Place) -> Mistake:
    text = f'"{name}" of {noun} cannot be written as JSON, in which parameters travel to workers'
    remedy = "let its class take numbers, text, lists and mappings, and make what it needs of them in setup"
    return Mistake(node.place if node is not None else place, text, remedy)


def _find(params: Mapping[str, Node], location: Sequence[int | str]) -> Node | None:
    """The innermost node on the way to a value."""
    node = params.get(str(location[0])) if location else None
    for part in location[1:]:
        inner: Node | None = None
        if node is not None and isinstance(node.value, Mapping):
            inner = node.value.get(str(part))
        elif node is not None and isinstance(node.value, tuple) and isinstance(part, int):
            inner = node.value[part] if part < len(node.value) else None
        if inner is None:
            break
        node = inner
    return node


def _about(info: FieldInfo | None) -> str:
    """Description of the parameter, with its unit."""
    if info is None or not info.description:
        return ""
    extra = info.json_schema_extra
    unit = extra.get("unit", "") if isinstance(extra, dict) else ""
    return f", {info.description}" + (f" ({unit})" if unit and unit != "1" else "")
