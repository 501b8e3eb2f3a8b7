"""What may be changed from the page: parameters that are no paths, and stages with the same ports.

A browser sends words, not data: they are checked here, and what they ask for is checked by the run.
"""

from __future__ import annotations

import json
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, get_args

from followspot.errors import FollowspotError
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.successor import misfits
from followspot.plugins.description import describe
from followspot.plugins.registry import PluginError, catalogue, load_stage
from followspot.ports import ports
from followspot.stage import Stage


def forms(plan: Plan) -> dict[str, dict[str, Any]]:
    """For each stage of the graph file the parameters that can be set, and who can take its place.

    Sources of recordings and sinks stay as they are: streams would begin anew, files be overwritten.
    """
    found = {}
    for planned in plan.stages:
        stage = load_stage(planned.uses)
        its = ports(stage)
        if planned.group not in found and its.outputs and (stage.live or not its.source):
            found[planned.group] = _form(planned, stage, plan)
    return found


def words_of(text: str, plan: Plan) -> list[str]:
    """The change that a browser asks for: `{"stage": ..., "key": ..., "value": ...}`, key "" to swap.

    Raises FollowspotError where it is none, or may not be asked for from a browser.
    """
    try:
        asked = json.loads(text)
        stage, key, value = (asked[name] for name in ("stage", "key", "value"))
    except (ValueError, KeyError, TypeError, RecursionError):
        raise FollowspotError("this is no change") from None
    if not (isinstance(stage, str) and isinstance(key, str) and isinstance(value, str)):
        raise FollowspotError("this is no change")
    allowed = forms(plan).get(stage, {"parameters": [], "alternatives": []})
    if key and key in {parameter["name"] for parameter in allowed["parameters"]}:
        return [f"{stage}.{key}={value}"]
    if not key and value in allowed["alternatives"]:
        return [f"{stage}={value}"]
    raise FollowspotError(f"{stage}{'.' if key else ''}{key} cannot be changed from the page")


def _form(planned: PlannedStage, stage: type[Stage], plan: Plan) -> dict[str, Any]:
    paths = {name for name, info in stage.Params.model_fields.items() if _is_path(info.annotation)}
    parameters = [p for p in describe(planned.uses, stage)["parameters"] if p["name"] not in paths]
    others = [name for name in _importable() if not misfits(planned, stage, load_stage(name), plan)]
    return {"parameters": parameters, "alternatives": sorted({planned.uses, *others})}


@cache
def _importable() -> tuple[str, ...]:
    """Installed stages that can be imported; `followspot plugins` tells what is wrong with the others."""
    found = []
    for name in sorted(catalogue()):
        with suppress(PluginError, ImportError, TypeError):
            ports(load_stage(name))
            found.append(name)
    return tuple(found)


def _is_path(annotation: Any) -> bool:
    return annotation is Path or any(_is_path(part) for part in get_args(annotation))
