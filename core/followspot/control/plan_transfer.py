"""Prepares a plan for transfer to another host: without code, absolute paths or other hosts' parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Any

from followspot.errors import FollowspotError
from followspot.graph.parameters import path_parameters
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.plugins.registry import load_stage
from followspot.security.grants import Grants
from followspot.stage_params import PathIn, PathOut


def packed(plan: Plan, host: str, media: Path) -> dict[str, Any]:
    """The plan to send to a host: paths of input files are relative to the folder `media`.

    Raises FollowspotError if a stage of that host reads a file that is not below `media`.
    """

    def stage_for(stage: PlannedStage) -> PlannedStage:
        if plan.host_of(stage.worker) != host:
            return replace(stage, params={})
        return _with_inputs(stage, lambda path: _name_below(path, media, stage.name))

    cameras = {name: replace(camera, source=None) for name, camera in plan.room.cameras.items()}
    sensors = {name: replace(sensor, source=None) for name, sensor in plan.room.sensors.items()}
    tune = {key: value for key, value in plan.room.tune.items() if _is_numeric(value)}
    room = replace(plan.room, cameras=cameras, sensors=sensors, truth=None, tune=tune)
    stages = tuple(stage_for(stage) for stage in plan.stages)
    return plan_to_data(replace(plan, room=room, stages=stages, plugin_files=()))


def _is_numeric(value: object) -> bool:
    """True for numbers, and lists and mappings of them; a text may be a path or address of another host."""
    if isinstance(value, Mapping):
        return all(map(_is_numeric, value.values()))
    return all(map(_is_numeric, value)) if isinstance(value, list | tuple) else not isinstance(value, str)


def unpacked(data: Any, host: str, grants: Grants, plugin_files: tuple[str, ...]) -> dict[str, Any]:
    """The plan for the host's workers: input files below its own media folder, plugins of its own.

    Raises FollowspotError if a stage is not installed or uses anything that is not granted.
    """
    plan = plan_from_data(data)
    if plan.plugin_files:
        raise FollowspotError("the plan brings code of its own; an agent runs only installed plugins")

    stages = tuple(_granted(s, grants) if plan.host_of(s.worker) == host else s for s in plan.stages)
    return plan_to_data(replace(plan, stages=stages, plugin_files=plugin_files))


def packed_stages(stages: Sequence[PlannedStage], media: Path) -> tuple[PlannedStage, ...]:
    """The stages to send to a host: paths of input files are relative to `media`; relative ones stay.

    Raises FollowspotError if a stage reads a file that is not below `media`.
    """
    return tuple(_with_inputs(s, lambda p, n=s.name: _name_below(p, media, n)) for s in stages)  # type: ignore[misc]


def unpacked_stages(stages: Sequence[PlannedStage], grants: Grants) -> tuple[PlannedStage, ...]:
    """The stages for the host's workers. Raises FollowspotError; see `unpacked`."""
    return tuple(_granted(stage, grants) for stage in stages)


def _granted(stage: PlannedStage, grants: Grants) -> PlannedStage:
    """The stage with the paths of its input files on this host. Raises FollowspotError; see `unpacked`."""
    _check_outputs(stage)
    grants.check(stage)
    return _with_inputs(stage, lambda name: _path_below(name, grants.media, stage.name))


def _with_inputs(stage: PlannedStage, change: Callable[[str], str]) -> PlannedStage:
    """The stage with `change` applied to the paths of its input files."""
    params = dict(stage.params)
    for name in path_parameters(load_stage(stage.uses).Params, PathIn):
        if params.get(name) is not None:
            params[name] = change(str(params[name]))
    return replace(stage, params=params)


def _check_outputs(stage: PlannedStage) -> None:
    for name in path_parameters(load_stage(stage.uses).Params, PathOut):
        value = stage.params.get(name)
        if value is not None and not _is_below(str(value)):
            raise FollowspotError(f"stage {stage.name} would write {value!r}, outside the run's folder")


def _name_below(path: str, media: Path, stage: str) -> str:
    """The path of a file relative to `media`; a relative path comes from a host and stays."""
    if not Path(path).is_absolute():
        return path
    try:
        return Path(path).resolve().relative_to(media.resolve()).as_posix()
    except ValueError:
        raise FollowspotError(
            f"stage {stage} reads {path}, which is not below {media}; "
            "agents take names below their own --media folder: name that folder here with --media"
        ) from None


def _path_below(name: str, media: Path | None, stage: str) -> str:
    if media is None:
        raise FollowspotError(
            f"stage {stage} reads the file {name!r}; start the agent with --media DIR, the folder it is in"
        )
    path = (media / name).resolve()
    if not _is_below(name) or not path.is_relative_to(media.resolve()):
        raise FollowspotError(f"stage {stage} would read {name!r}, outside the agent's media folder")
    if not path.exists():
        raise FollowspotError(f"stage {stage} reads {name!r}, which is not in the agent's media folder")
    return str(path)


def _is_below(name: str) -> bool:
    """True if a relative path stays below the folder that it is joined to."""
    parts = PurePath(name).parts
    return bool(parts) and not PurePath(name).is_absolute() and ".." not in parts and "\0" not in name
