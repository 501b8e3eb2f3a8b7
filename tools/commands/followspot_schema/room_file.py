"""Room files: cameras, planes, targets."""

from __future__ import annotations

from collections.abc import Mapping

from followspot.points import Points2D
from followspot.ports.signature import ports
from followspot.room_document.sync import LARGEST_KEY, MATCHES, TRIGGERS
from followspot.room_document.target import BINS
from followspot.stage import Stage
from followspot.tracking import DepthImage, Frame
from followspot_schema.parts import NAME, TEXT, Schema, form, matrix, named, numbers
from followspot_schema.stages import models, stage_use, stages_offered

WORD: Schema = {"type": "string", "pattern": NAME}
POSITIVE: Schema = {"type": "number", "exclusiveMinimum": 0}


def room_schema() -> Schema:
    """The schema of a room file with all installed sources of what cameras see, and of truth."""
    sources = {name: stage for name, stage in stages_offered().items() if ports(stage).source}
    pictures = {name: stage for name, stage in sources.items() if _looks(stage)}
    others = {name: stage for name, stage in sources.items() if name not in pictures}
    return form(
        "the calibrated place, in metres, z up",
        {
            "room": {**TEXT, "description": "name of the room"},
            "cameras": named("name -> camera", _camera(pictures)),
            "sensors": named("name -> sensor", _sensor(others)),
            "planes": named("name -> plane", numbers(4, "a b c d: a x + b y + c z + d = 0, unit normal, m")),
            "targets": named("name -> target", _target()),
            "tune": {
                "type": "object",
                "propertyNames": {"pattern": r"^[^.\s]+(\.[^.\s]+)+$"},
                "description": "values that suit the place: plugin.name.parameter or stage.parameter, where"
                " needed with /camera before the parameter",
            },
            "sync": _sync(),
            "truth": stage_use(
                "source of the ground truth, if there is one",
                others,
            ),
        },
    ) | {"$defs": models(sources)}


def _sync() -> Schema:
    key: Schema = {"type": "integer", "minimum": 0, "maximum": LARGEST_KEY, "default": 1}
    return form(
        "how the cameras are triggered together",
        {
            "trigger": {"enum": list(TRIGGERS), "description": "what triggers them"},
            "camera": {**TEXT, "description": "the camera that leads; needed for line and action"},
            "rate": {
                **POSITIVE,
                "description": "triggers a second; a line needs none, but pictures are then matched by time",
            },
            "device_key": {**key, "description": "of action commands"},
            "group_key": {**key, "description": "of action commands"},
            "group_mask": {**key, "description": "of action commands"},
            "match": {
                "enum": list(MATCHES),
                "default": "number",
                "description": "what tells which pictures are of one trigger",
            },
        },
    )


def _looks(stage: type[Stage]) -> bool:
    """Whether it gives what a camera sees: pictures, or points that a network found in them."""
    return any(port.type in (Frame, DepthImage, Points2D) for port in ports(stage).outputs)


def _camera(pictures: Mapping[str, type[Stage]]) -> Schema:
    return form(
        "OpenCV convention: x_cam = R X + t, z forward",
        {
            "kind": {**WORD, "description": "color, infrared, depth, or another word that graphs ask for"},
            "size": {**numbers(2, "width and height, px"), "items": {"type": "integer", "minimum": 1}},
            "model": {"enum": ["pinhole", "rational", "fisheye", "cylinder"], "default": "pinhole"},
            "matrix": matrix("[[fx, 0, cx], [0, fy, cy], [0, 0, 1]], px"),
            "distortion": {
                "type": "array",
                "items": {"type": "number"},
                "maxItems": 8,
                "description": "k1 k2 p1 p2 k3, and k4 k5 k6 if rational; k1 k2 k3 k4 of a fisheye",
            },
            "rotation": matrix("R of x_cam = R X + t"),
            "translation": numbers(3, "t of x_cam = R X + t, m"),
            "source": stage_use("the stage that gives its pictures", pictures),
            "host": {"type": "string", "description": "the host that it is connected to"},
            "clock_offset": {
                "type": "number",
                "minimum": -1,
                "maximum": 1,
                "description": "how much later than its time stamps say it takes its pictures, s",
            },
            "tags": _tags(),
        },
        ["kind", "size", "matrix", "rotation", "translation"],
    )


def _sensor(others: Mapping[str, type[Stage]]) -> Schema:
    return form(
        "a device that is no camera",
        {
            "kind": {**WORD, "description": "imu, or another word that graphs ask for"},
            "source": stage_use("the stage that gives its readings", others),
            "rate": {**POSITIVE, "maximum": 1e6, "description": "readings a second, 1/s"},
            "mount": {
                "type": "object",
                "description": "the target or the camera that carries it",
                "properties": {"target": TEXT, "camera": TEXT},
                "additionalProperties": False,
                "minProperties": 1,
                "maxProperties": 1,
            },
            "host": {"type": "string", "description": "the host that it is connected to"},
            "tags": _tags(),
        },
        ["kind"],
    )


def _tags() -> Schema:
    values: Schema = {"anyOf": [WORD, {"type": "integer"}]}
    several: Schema = {"type": "array", "items": values, "minItems": 1}
    return named(
        "free words, as in zone: hall, or zone: [hall, stage]", {"anyOf": [*values["anyOf"], several]}
    )


def _target() -> Schema:
    span = numbers(2, "smallest and largest")
    return form(
        "an object to track and its template",
        {
            "radius": {**POSITIVE, "description": "m"},
            "hue_histogram": named("camera -> histogram", numbers(BINS, f"{BINS} bins")),
            "area": named("camera -> smallest and largest area, px", span),
            "gray": named("infrared camera -> lowest and highest grey level", span),
            "tags": _tags(),
        },
        ["radius"],
    )
