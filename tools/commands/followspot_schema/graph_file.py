"""Graph files: the envelope of a stage, then its own parameters and ports by what it uses."""

from __future__ import annotations

from collections.abc import Mapping

from followspot.ports import ports
from followspot.stage import Stage
from followspot_schema.parts import FREE, TEXT, Schema, form, named
from followspot_schema.stages import REFERENCE, models, parameters, stages_offered

ROOM_SOURCE = "room.source"
"""Stands for the source that the room declares for each camera; no plugin offers it."""
FOR_PORT: Schema = {"type": "string", "pattern": r"^[\w.]+\[[\w.]+\]$", "description": "NAME[STAGE.PORT]"}


def graph_schema() -> Schema:
    """The schema of a graph file with all installed stages."""
    offered = stages_offered()
    one_or_more: Schema = {"anyOf": [TEXT, {"type": "array", "items": TEXT, "minItems": 1}]}
    return form(
        "stages and the edges between them",
        {
            "graph": {**TEXT, "description": "name of the graph"},
            "room": {**TEXT, "description": "room file, relative to this one; --room swaps it"},
            "include": {**one_or_more, "description": "graph files whose stages are taken in"},
            "vars": {**FREE, "description": "values for ${NAME} in this graph"},
            "seed": {"type": "integer", "minimum": 0, "description": "of all random numbers"},
            "stages": named("name -> stage", {"$ref": "#/$defs/stage"}),
        },
        ["stages"],
    ) | {"$defs": {"stage": _stage(offered), "feed": _feed(), **models(offered)}}


def _stage(offered: Mapping[str, type[Stage]]) -> Schema:
    """The keys of every stage, and the parameters and inputs of each installed one."""
    envelope = form(
        "one step of work",
        {
            "uses": {
                "anyOf": [{"enum": [ROOM_SOURCE, *offered]}, FOR_PORT, REFERENCE],
                "description": "which stage; `followspot plugins` lists them",
            },
            "each": {
                "type": "string",
                "pattern": r"^\s*(cameras\s*(\[.*\])?|\$\{.+\})\s*$",
                "description": 'one instance a camera: cameras, or "cameras[kind=color]"',
            },
            "in": {"type": "object", "description": "input port -> what feeds it"},
            "with": {"type": "object", "description": "parameters"},
            "on_error": {
                "enum": ["fail", "skip", "restart"],
                "description": "what follows an exception: the run ends, the message is left out and counted,"
                " or the stage is built anew",
            },
            "tolerance": {"type": "number", "minimum": 0, "description": "of joining by capture time, s"},
            "deadline": {"type": "number", "minimum": 0, "description": "longest wait of a live join, s"},
        },
        ["uses"],
    )
    return envelope | {"allOf": [_of(name, stage) for name, stage in offered.items()]}


def _of(name: str, stage: type[Stage]) -> Schema:
    found = ports(stage)
    feeds = {p.name: {"$ref": "#/$defs/feed"} for p in found.inputs}
    need = [p.name for p in found.inputs if p.required]
    described = form(f"inputs of {name}", feeds, need)
    says: Schema = {"properties": {"in": described, "with": parameters(name, stage, variables=True)}}
    must = [
        key for key, wanted in (("in", need), ("with", says["properties"]["with"].get("required"))) if wanted
    ]
    if must:
        says["required"] = must
    return {"if": {"properties": {"uses": {"const": name}}, "required": ["uses"]}, "then": says}


def _feed() -> Schema:
    one = form(
        "STAGE or STAGE.PORT, with options",
        {
            "from": {**TEXT, "description": "STAGE or STAGE.PORT"},
            "delay": {
                "anyOf": [{"type": "integer", "minimum": 0}, REFERENCE],
                "description": "frames; for feedback",
            },
            "depth": {
                "anyOf": [{"type": "integer", "minimum": 1}, REFERENCE],
                "description": "longest queue",
            },
            "codec": {"enum": ["raw", "lossless", "jpeg"], "description": "of pictures between hosts"},
            "policy": {
                "enum": ["block", "drop_oldest", "latest"],
                "description": "when the queue is full, in live runs: the sender waits, or the oldest goes",
            },
        },
        ["from"],
    )
    either: Schema = {"anyOf": [TEXT, one]}
    return {"anyOf": [TEXT, one, {"type": "array", "items": either, "minItems": 1}]}
