"""Description of a stage as data, for the command line, the reference, editors and pages."""

from __future__ import annotations

import inspect
from dataclasses import asdict
from typing import Any, Literal, get_args, get_origin

from followspot.ports.signature import ports
from followspot.stage import Stage

_SIGNS = {
    "Gt": ">",
    "Ge": ">=",
    "Lt": "<",
    "Le": "<=",
    "MultipleOf": "multiple of",
    "MinLen": "length >=",
    "MaxLen": "length <=",
}
"""Limits of a parameter as they are written."""


def describe(name: str, stage: type[Stage]) -> dict[str, Any]:
    """Text, inputs, outputs, parameters and a line for a graph file, of a stage, in JSON types."""
    found = ports(stage)
    return {
        "name": name,
        "description": inspect.cleandoc(stage.__doc__ or ""),
        "inputs": [
            {"name": p.name, "type": p.type.__name__, "kind": p.kind, "required": p.required}
            for p in found.inputs
        ],
        "outputs": [{"name": p.name, "type": p.type.__name__} for p in found.outputs],
        "gives": found.gives,
        "parameters": [_parameter(key, info) for key, info in stage.Params.model_fields.items()],
        "example": _example(name, stage),
    }


def _parameter(name: str, info: Any) -> dict[str, Any]:
    """Description of a parameter in JSON types."""
    limits = [
        f"{_SIGNS[type(m).__name__]} {next(iter(asdict(m).values()))}"
        for m in info.metadata
        if type(m).__name__ in _SIGNS
    ]
    return {
        "name": name,
        "type": getattr(info.annotation, "__name__", str(info.annotation)),
        "default": None if info.is_required() else _plain(_default(info)),
        "required": info.is_required(),
        "range": ", ".join(limits) or _choices(info.annotation),
        "unit": (info.json_schema_extra or {}).get("unit", ""),
        "description": info.description or "",
    }


def _default(info: Any) -> Any:
    """The default; None if it is computed from other parameters."""
    return None if info.default_factory_takes_validated_data else info.get_default(call_default_factory=True)


def _choices(annotation: Any) -> str:
    """The values of a Literal, else nothing."""
    return " | ".join(map(str, get_args(annotation))) if get_origin(annotation) is Literal else ""


def _plain(value: Any) -> Any:
    return value if isinstance(value, (int, float, str, bool, list, dict, type(None))) else str(value)


def _example(name: str, stage: type[Stage]) -> str:
    """A line for a graph file."""
    feeds = ", ".join(f"{p.name}: ..." for p in ports(stage).inputs if p.required)
    required = ", ".join(f"{k}: ..." for k, info in stage.Params.model_fields.items() if info.is_required())
    parts = [f"uses: {name}"]
    if stage.serves():
        parts.append(f"each: {stage.serves()}")
    if feeds:
        parts.append(f"in: {{{feeds}}}")
    if required:
        parts.append(f"with: {{{required}}}")
    return f"{name.rpartition('.')[2]}: {{{', '.join(parts)}}}"
