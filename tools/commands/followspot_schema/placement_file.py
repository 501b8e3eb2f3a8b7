"""Placement files: which worker runs what, and on which host."""

from __future__ import annotations

from followspot_schema.parts import TEXT, Schema, form, named


def placement_schema() -> Schema:
    """The schema of a placement file."""
    names: Schema = {"type": "array", "items": TEXT}
    worker = form(
        "one process",
        {
            "stages": {**names, "description": "stages of the graph, or instances as in color/cam0"},
            "cameras": {**names, "description": "cameras, with all stages that serve one of them"},
            "sensors": {**names, "description": "sensors, likewise"},
            "cores": {
                "type": "array",
                "items": {"type": "integer", "minimum": 0, "maximum": 1023},
                "description": "cores that it keeps to",
            },
            "nice": {
                "type": "integer",
                "minimum": -20,
                "maximum": 19,
                "description": "priority; 19 yields to all others",
            },
            "realtime": {
                "type": "integer",
                "minimum": 1,
                "maximum": 99,
                "description": "priority of SCHED_FIFO, before all ordinary processes",
            },
            "host": {"type": "string", "description": "name of the agent that runs it"},
        },
    )
    return form(
        "stages into workers, workers onto hosts; what is not named runs in the worker main",
        {
            "placement": {**TEXT, "description": "name of the placement"},
            "by": {
                "enum": ["camera", "stage", "auto"],
                "description": "one worker per camera, per stage, or what is fastest by measured work",
            },
            "costs": {
                **TEXT,
                "description": "report of an earlier run (--json), with the work of its stages",
            },
            "aim": {"enum": ["throughput", "latency"], "description": "of by: auto"},
            "budget": {
                "type": "object",
                "additionalProperties": {"type": "string", "pattern": r"^\d+(\.\d+)?\s*(us|ms|s)$"},
                "description": "longest times, SOURCE -> STAGE: 20 ms",
            },
            "workers": named("name -> worker", worker),
        },
    )
