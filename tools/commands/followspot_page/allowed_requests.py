"""Requests that the page allows: parameters that name no files or devices, and stages with equal ports.

A browser sends words, not data. This module checks the words; the run checks the change.
"""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import pydantic

from followspot.errors import FollowspotError
from followspot.graph.change.replacement import mismatches
from followspot.graph.parameters import path_parameters
from followspot.graph.plan import Plan, PlannedStage
from followspot.plugins.catalogue import catalogue
from followspot.plugins.description import describe
from followspot.plugins.registry import PluginError, load_stage
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot.stage_params import DeviceIn, NetworkOut

MOST_CURVES = 8
"""Figures that one browser plots at once, beside those of the run."""
_Pixel = Annotated[int, pydantic.Field(ge=0, le=1 << 16)]


def forms(plan: Plan) -> dict[str, dict[str, Any]]:
    """The parameters and possible replacements of each stage of the graph file.

    Sources of recordings and sinks are left out: streams would restart, files be overwritten.
    """
    found = {}
    for planned in plan.stages:
        stage = load_stage(planned.uses)
        its = ports(stage)
        if planned.group not in found and its.outputs and (stage.live or not its.source):
            found[planned.group] = _form(planned, stage, plan)
    return found


@dataclass(frozen=True)
class Change:
    """A parameter to set, or with the key "" a stage to swap in."""

    stage: str
    key: str
    value: str


@dataclass(frozen=True)
class Record:
    """A recording to start or stop. ports: as `--record-ports` takes them, "" for all."""

    on: bool
    ports: str = ""


@dataclass(frozen=True)
class Hold:
    """A pause, its end, or a step of so many capture times."""

    hold: Literal["pause", "resume", "step"]
    count: Annotated[int, pydantic.Field(ge=1, le=1000)] = 1


@dataclass(frozen=True)
class MarkRequest:
    """A moment to save. mark: a note, "" for none."""

    mark: Annotated[str, pydantic.Field(max_length=200)]


@dataclass(frozen=True)
class Save:
    """Save what was changed as an overlay."""

    save: Literal[True]


@dataclass(frozen=True)
class OpenPage:
    """Begin the page of another run. open: the run's name."""

    open: Annotated[str, pydantic.Field(max_length=64)]


@dataclass(frozen=True)
class Seek:
    """Another moment of a recording. seek: s of capture time, None for the present one; play: from there."""

    seek: Annotated[float, pydantic.Field(allow_inf_nan=False)] | None
    play: bool


@dataclass(frozen=True)
class Still:
    """A picture of a camera to learn a target from. still: the camera."""

    still: Annotated[str, pydantic.Field(max_length=200)]


@dataclass(frozen=True)
class Learn:
    """A target to learn from the newest still picture.

    learn: its name; box: a click x, y or a rectangle x, y, width, height, px; radius: m, None for that of the
    room file.
    """

    learn: Annotated[str, pydantic.Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")]
    box: tuple[_Pixel, _Pixel] | tuple[_Pixel, _Pixel, _Pixel, _Pixel]
    radius: Annotated[float, pydantic.Field(gt=0, le=10, allow_inf_nan=False)] | None


@dataclass(frozen=True)
class Write:
    """Write the target that was learnt into the room file."""

    write: Literal[True]


@dataclass(frozen=True)
class Curve:
    """A figure of the messages of a port, STAGE.PORT.

    row: what stands in the column that names rows, or the number of a row; field: a column of the table.
    """

    port: Annotated[str, pydantic.Field(max_length=200)]
    row: Annotated[str, pydantic.Field(max_length=64)]
    field: Annotated[str, pydantic.Field(max_length=100)]


@dataclass(frozen=True)
class Plot:
    """Replace the curves that this browser plots."""

    plot: Annotated[tuple[Curve, ...], pydantic.Field(max_length=MOST_CURVES)]


PageRequest = Change | Record | Hold | MarkRequest | Save | OpenPage | Seek | Still | Learn | Write | Plot
_REQUEST: pydantic.TypeAdapter[PageRequest] = pydantic.TypeAdapter(
    PageRequest, config=pydantic.ConfigDict(strict=True)
)


def request_of(text: str) -> PageRequest:
    """A browser's request, in JSON. Raises FollowspotError."""
    try:
        return _REQUEST.validate_json(text)
    except (ValueError, RecursionError):
        raise FollowspotError("this is nothing that can be asked for") from None


def sentence(error: str) -> str:
    """The text of a mistake beside its field: without the place in the command, and without the stage."""
    first = error.splitlines()[0] if error else ""
    return _STAGE.sub("", _PLACE.sub("", first))


_PLACE = re.compile(r"^\S+:\d+:\d+: ")
_STAGE = re.compile(r'^stage "[^"]*" \([^)]*\) cannot be so: | of stage "[^"]*" \([^)]*\)')


def words_of(change: Change, plan: Plan) -> list[str]:
    """A change as `followspot set` and `swap` take it. Raises FollowspotError if the page may not ask it."""
    stage, key, value = change.stage, change.key, change.value
    allowed = forms(plan).get(stage, {"parameters": [], "alternatives": []})
    if key and key in {parameter["name"] for parameter in allowed["parameters"]}:
        return [f"{stage}.{key}={value}"]
    if not key and value in allowed["alternatives"]:
        return [f"{stage}={value}"]
    raise FollowspotError(f"{stage}{'.' if key else ''}{key} cannot be changed from the page")


def _form(planned: PlannedStage, stage: type[Stage], plan: Plan) -> dict[str, Any]:
    paths = {name for name, info in stage.Params.model_fields.items() if _is_path(info.annotation)}
    kept = {*paths, *(n for mark in (DeviceIn, NetworkOut) for n in path_parameters(stage.Params, mark))}
    parameters = [p for p in describe(planned.uses, stage)["parameters"] if p["name"] not in kept]
    others = [name for name in _importable() if not mismatches(planned, stage, load_stage(name), plan)]
    return {"parameters": parameters, "alternatives": sorted({planned.uses, *others})}


@cache
def _importable() -> tuple[str, ...]:
    """Installed stages that can be imported; `followspot plugins` reports the others."""
    found = []
    for name in sorted(catalogue()):
        with suppress(PluginError, ImportError, TypeError):
            ports(load_stage(name))
            found.append(name)
    return tuple(found)


def _is_path(annotation: Any) -> bool:
    return annotation is Path or any(_is_path(part) for part in get_args(annotation))
