"""Graph files: the envelope of a stage, then its own parameters and ports by what it uses."""

from __future__ import annotations

from collections.abc import Mapping

from followspot.graph.declaration import ROOM_SOURCE
from followspot.ports.signature import ports
from followspot.stage import Stage
from followspot_schema.parts import NAME, TEXT, Schema, form, named
from followspot_schema.stages import models, parameters, stages_offered

_STAGE_NAME = f"^{NAME.strip('^$')}(/{NAME.strip('^$')})*$"
_INTERFACE = (
    ("parameter", "STAGE.PARAMETER, which a graph around this one sets"),
    ("input", "STAGE, whose place a stage around this graph takes, or STAGE.PORT"),
    ("output", "STAGE or STAGE.PORT, which a graph around this one reads"),
)
_OPTIONAL: Schema = {
    "type": "boolean",
    "description": "true: leave it out if the room has nothing for it",
}
FOR_PORT: Schema = {"type": "string", "pattern": r"^[\w.]+\[[\w.]+\]$", "description": "NAME[STAGE.PORT]"}


def graph_schema() -> Schema:
    """The schema of a graph file with all installed stages."""
    offered = stages_offered()
    stage, subgraph = _stage(offered), _subgraph()
    keys = {**stage["properties"], **subgraph["properties"]}
    of = [f"{name} of the interface -> {what}" for name, what in _INTERFACE]
    whole = form(
        "stages and the edges between them",
        {
            "graph": {**TEXT, "description": "name of the graph"},
            "extends": {**TEXT, "description": "graph file that this one changes, relative to this one"},
            "room": {**TEXT, "description": "room file, relative to this one; --room swaps it"},
            "params": _names(of[0], several=True),
            "inputs": _names(of[1], several=True),
            "outputs": _names(of[2]),
            "seed": {"type": "integer", "minimum": 0, "description": "of all random numbers"},
            "stages": {
                "type": "object",
                "description": "name -> stage",
                "propertyNames": {"pattern": _STAGE_NAME},
            },
        },
    )
    changes: Schema = {"stages": {"additionalProperties": {"$ref": "#/$defs/change"}}}
    entries: Schema = {"stages": {"additionalProperties": {"$ref": "#/$defs/entry"}}}
    return whole | {
        "if": {"required": ["extends"]},
        "then": {"properties": changes},
        "else": {"properties": entries, "required": ["stages"]},
        "$defs": {
            "entry": {
                "if": {"required": ["graph"]},
                "then": {"$ref": "#/$defs/subgraph"},
                "else": {"$ref": "#/$defs/stage"},
            },
            "change": {
                "anyOf": [
                    form("what differs from the extended file", {key: {} for key in keys}),
                    {"type": "null"},
                ]
            },
            "stage": stage,
            "subgraph": subgraph,
            "feed": _feed(),
            **models(offered),
        },
    }


def _names(description: str, *, several: bool = False) -> Schema:
    """Names of the interface; null removes one of an extended file."""
    listed: list[Schema] = [{"type": "array", "items": TEXT, "minItems": 1}] if several else []
    return named(description, {"anyOf": [TEXT, *listed, {"type": "null"}]})


def _subgraph() -> Schema:
    """The keys of a stage that is a sub-graph."""
    return form(
        "a graph file as a stage",
        {
            "graph": {**TEXT, "description": "graph file, relative to this one"},
            "cameras": {"type": "string", "description": 'which cameras it serves: "cameras[kind=color]"'},
            "each": {"type": "string", "description": "one instance of it for each of these"},
            "with": {"type": "object", "description": "parameters of its interface"},
            "in": {
                "type": "object",
                "description": "input of its interface -> what feeds it",
                "additionalProperties": {"$ref": "#/$defs/feed"},
            },
            "optional": _OPTIONAL,
        },
        ["graph"],
    )


def _stage(offered: Mapping[str, type[Stage]]) -> Schema:
    """The keys of every stage, and the parameters and inputs of each installed one."""
    envelope = form(
        "one step of work",
        {
            "uses": {
                "anyOf": [{"enum": [ROOM_SOURCE, *offered]}, FOR_PORT],
                "description": "which stage; `followspot plugins` lists them",
            },
            "each": {
                "type": "string",
                "pattern": r"^\s*[\w-]+\s*(\[.*\])?\s*$",
                "description": "one instance a member: cameras, sensors, targets or a tag as in zones, also"
                ' "cameras[kind=color, zone=hall]"',
            },
            "serves": {
                "anyOf": [TEXT, {"type": "array", "items": TEXT}],
                "description": 'members of the sub-graphs around it, in a flat file: "zone[name=hall]"',
            },
            "sees": {
                "anyOf": [TEXT, {"type": "array", "items": TEXT}],
                "description": "cameras that the sub-graphs around it are given, in a flat file:"
                ' "cameras[zone=hall]"; it knows no others',
            },
            "optional": _OPTIONAL,
            "in": {"type": "object", "description": "input port -> what feeds it"},
            "with": {"type": "object", "description": "parameters"},
            "on_error": {
                "enum": ["fail", "skip", "restart"],
                "description": "what follows an exception: the run ends, the message is left out and counted,"
                " or the stage is built anew",
            },
            "tolerance": {"type": "number", "minimum": 0, "description": "of joining by capture time, s"},
            "deadline": {"type": "number", "minimum": 0, "description": "longest wait of a live join, s"},
            "depth": {"type": "integer", "minimum": 1, "description": "of a live source: messages that wait"},
            "concurrency": {"type": "integer", "minimum": 1, "description": "most deferred answers at once"},
        },
        ["uses"],
    )
    return envelope | {"allOf": [_of(name, stage) for name, stage in offered.items()]}


def _of(name: str, stage: type[Stage]) -> Schema:
    found = ports(stage)
    feed: Schema = {"$ref": "#/$defs/feed"}
    need = [p.name for p in found.inputs if p.required and not found.any_name]
    described = form(f"inputs of {name}", {p.name: feed for p in found.inputs}, need)
    if found.any_name:
        described = named(f"the input of {name}, under any name", feed)
    says: Schema = {"properties": {"in": described, "with": parameters(name, stage)}}
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
            "only": {**TEXT, "description": 'which instances of the sender: "cameras[zone=hall]"'},
            "delay": {"type": "integer", "minimum": 0, "description": "frames; for feedback"},
            "depth": {"type": "integer", "minimum": 1, "description": "longest queue"},
            "tolerance": {"type": "number", "minimum": 0, "description": "of matching by capture time, s"},
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
