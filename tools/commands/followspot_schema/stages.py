"""Parameters of installed stages, for every file that names one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from followspot.plugins.registry import PluginError, load_stage, stage_names
from followspot.stage import Stage
from followspot_schema.parts import Schema, form


def stages_offered() -> dict[str, type[Stage]]:
    """The stages that work here, by name; of others the editor need not know."""
    return {name: stage for name in stage_names() if (stage := _loaded(name)) is not None}


def stage_use(description: str, offered: Mapping[str, type[Stage]]) -> Schema:
    """One of these stages with its parameters, as a room names it."""
    keys: Schema = {
        "uses": {"enum": list(offered), "description": "which stage; `followspot plugins` lists them"},
        "with": {"type": "object", "description": "parameters"},
    }
    return form(description, keys, ["uses"]) | {
        "allOf": [_of(name, stage) for name, stage in offered.items()]
    }


def parameters(name: str, stage: type[Stage]) -> Schema:
    """The parameters, each with its unit."""
    model = _model(name, stage)
    described = {key: _parameter(field) for key, field in model.get("properties", {}).items()}
    return form(f"parameters of {name}", described, model.get("required", ()))


def models(offered: Mapping[str, type[Stage]]) -> Schema:
    """Models within parameters, under names of their own."""
    found: Schema = {}
    for name, stage in offered.items():
        inner = _model(name, stage).get("$defs", {})
        found |= {f"{name}.{key}": value for key, value in inner.items()}
    return found


def _of(name: str, stage: type[Stage]) -> Schema:
    """The condition that checks the parameters of one stage."""
    taken = parameters(name, stage)
    then: Schema = {"properties": {"with": taken}} | ({"required": ["with"]} if "required" in taken else {})
    return {"if": {"properties": {"uses": {"const": name}}, "required": ["uses"]}, "then": then}


def _model(name: str, stage: type[Stage]) -> dict[str, Any]:
    return stage.Params.model_json_schema(ref_template=f"#/$defs/{name}.{{model}}")


def _parameter(field: Schema) -> Schema:
    unit = field.get("unit")
    text = field.get("description", "") + (f" ({unit})" if unit and unit != "1" else "")
    apart = ("unit", "title", "description", "default")
    found = {**{key: value for key, value in field.items() if key not in apart}, "description": text}
    return found | ({"default": field["default"]} if "default" in field else {})


def _loaded(name: str) -> type[Stage] | None:
    try:
        return load_stage(name)
    except PluginError:
        return None
