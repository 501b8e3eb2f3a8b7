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
            "host": {"type": "string", "description": "name of the agent that runs it"},
        },
    )
    return form(
        "stages into workers, workers onto hosts; what is not named runs in the worker main",
        {
            "placement": {**TEXT, "description": "name of the placement"},
            "by": {"enum": ["camera", "stage"], "description": "one worker per camera, or per stage"},
            "workers": named("name -> worker", worker),
        },
    )
