"""The plan that a recording embeds; a file from elsewhere is read with suspicion."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePath

import pydantic

from followspot.errors import FollowspotError, InputError, Mistake
from followspot.graph.parameters import output_paths
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.plan_data import PlanDataError, plan_from_data
from followspot.plugins.registry import load_stage, use_plugin_files
from followspot_record.record import PLAN
from followspot_record.replay_plan import on_this_host
from followspot_recording.recording import Recording


def recorded_plan(recording: Recording, plugin_files: Sequence[str]) -> Plan:
    """The plan of the recorded run, for this host. Raises FollowspotError.

    plugin_files: Python files that the user names; files that the recording names are never loaded.
    """
    files = tuple(str(Path(file).absolute()) for file in plugin_files)
    use_plugin_files(files)
    plan = replace(plan_of_recording(recording), plugin_files=files)
    mistakes = [mistake for stage in plan.stages for mistake in stage_mistakes(stage)]
    if mistakes:
        raise InputError(mistakes)
    return on_this_host(plan)


def plan_of_recording(recording: Recording) -> Plan:
    """The plan in the file, unchecked. Raises FollowspotError."""
    data = recording.attachment(PLAN)
    try:
        return plan_from_data(json.loads(data))
    except PlanDataError as error:
        raise FollowspotError(f"{recording.path}: {PLAN}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise FollowspotError(f"{recording.path}: {PLAN} is damaged: {error}") from None


def offered_ports(recording: Recording) -> dict[str, tuple[str, ...]]:
    """The recorded ports behind each output of a sub-graph: see `Plan.offered`. Raises FollowspotError."""
    offered = plan_of_recording(recording).offered if PLAN in recording.attachments else {}
    found = {name: tuple(p for p in ports if p in recording.ports) for name, ports in offered.items()}
    return {name: ports for name, ports in found.items() if ports}


def stage_mistakes(stage: PlannedStage) -> list[Mistake]:
    """Mistakes in a stage's parameters: unknown ones, and outputs outside the output folder."""
    try:
        kind = load_stage(stage.uses)
        params = kind.Params(**stage.params)
    except FollowspotError as error:
        remedy = "install the plugin that offers it, or name its file with --plugin"
        return [Mistake(None, f'the recorded stage "{stage.name}": {error}', remedy)]
    except pydantic.ValidationError as error:
        first = error.errors()[0]
        text = f'the recorded stage "{stage.name}" ({stage.uses}): {first["loc"]}: {first["msg"]}'
        return [Mistake(None, text, "replay it with the version that recorded it, or name a --graph")]
    return [
        Mistake(None, f'the recorded stage "{stage.name}" would write {path}', "name another --graph")
        for path in map(PurePath, output_paths(kind.Params, params.model_dump(mode="json")))
        if path.is_absolute() or ".." in path.parts
    ]
