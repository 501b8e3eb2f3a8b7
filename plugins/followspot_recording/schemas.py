"""Foxglove's schemas in JSON, as far as messages are shown by them."""

from __future__ import annotations

import json
from typing import Any

from followspot_recording.recorder import Schema


def _object(title: str = "", **properties: Any) -> dict[str, Any]:
    made = {"type": "object", "properties": properties, "required": list(properties)}
    return {"title": title, **made} if title else made


def _array(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_TEXT, _NUMBER = {"type": "string"}, {"type": "number"}
_WHOLE = {"type": "integer", "minimum": 0}
_BYTES = {"type": "string", "contentEncoding": "base64"}
_TIME = _object("time", sec=_WHOLE, nsec={**_WHOLE, "maximum": 999_999_999})
_DURATION = _object("duration", sec={"type": "integer"}, nsec={**_WHOLE, "maximum": 999_999_999})
_VECTOR = _object("foxglove.Vector3", x=_NUMBER, y=_NUMBER, z=_NUMBER)
_QUATERNION = _object("foxglove.Quaternion", x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)
_POSE = _object("foxglove.Pose", position=_VECTOR, orientation=_QUATERNION)
_COLOR = _object("foxglove.Color", r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)
_SPHERE = _object("foxglove.SpherePrimitive", pose=_POSE, size=_VECTOR, color=_COLOR)
_LABEL = _object(
    "foxglove.TextPrimitive",
    pose=_POSE,
    billboard={"type": "boolean"},
    font_size=_NUMBER,
    scale_invariant={"type": "boolean"},
    color=_COLOR,
    text=_TEXT,
)
_ANY = _array({"type": "object"})
_PACKED = _object("foxglove.PackedElementField", name=_TEXT, offset=_WHOLE, type=_WHOLE)
_MARKS = _object(
    "foxglove.PointsAnnotation",
    timestamp=_TIME,
    type=_WHOLE,
    points=_array(_object("foxglove.Point2", x=_NUMBER, y=_NUMBER)),
    outline_color=_COLOR,
    outline_colors=_array(_COLOR),
    fill_color=_COLOR,
    thickness=_NUMBER,
    metadata=_ANY,
)
_ENTITY = _object(
    "foxglove.SceneEntity",
    timestamp=_TIME,
    frame_id=_TEXT,
    id=_TEXT,
    lifetime=_DURATION,
    frame_locked={"type": "boolean"},
    metadata=_ANY,
    arrows=_ANY,
    cubes=_ANY,
    spheres=_array(_SPHERE),
    cylinders=_ANY,
    lines=_ANY,
    triangles=_ANY,
    texts=_array(_LABEL),
    models=_ANY,
)


def _schema(name: str, /, **properties: Any) -> Schema:
    return Schema(name, "jsonschema", json.dumps(_object(name, timestamp=_TIME, **properties)))


COMPRESSED_IMAGE = _schema("foxglove.CompressedImage", frame_id=_TEXT, data=_BYTES, format=_TEXT)
RAW_IMAGE = _schema(
    "foxglove.RawImage", frame_id=_TEXT, width=_WHOLE, height=_WHOLE, encoding=_TEXT, step=_WHOLE, data=_BYTES
)
POSES_IN_FRAME = _schema("foxglove.PosesInFrame", frame_id=_TEXT, poses=_array(_POSE))
LOG = _schema(
    "foxglove.Log", level={"enum": [0, 1, 2, 3, 4, 5]}, message=_TEXT, name=_TEXT, file=_TEXT, line=_WHOLE
)
POINT_CLOUD = _schema(
    "foxglove.PointCloud",
    frame_id=_TEXT,
    pose=_POSE,
    point_stride=_WHOLE,
    fields=_array(_PACKED),
    data=_BYTES,
)
IMAGE_ANNOTATIONS = _schema(
    "foxglove.ImageAnnotations", circles=_ANY, points=_array(_MARKS), texts=_ANY, metadata=_ANY
)
CAMERA_CALIBRATION = _schema(
    "foxglove.CameraCalibration",
    frame_id=_TEXT,
    width=_WHOLE,
    height=_WHOLE,
    distortion_model=_TEXT,
    D=_array(_NUMBER),
    K=_array(_NUMBER),
    R=_array(_NUMBER),
    P=_array(_NUMBER),
)
FRAME_TRANSFORM = _schema(
    "foxglove.FrameTransform",
    parent_frame_id=_TEXT,
    child_frame_id=_TEXT,
    translation=_VECTOR,
    rotation=_QUATERNION,
)
SCENE_UPDATE = Schema(
    "foxglove.SceneUpdate",
    "jsonschema",
    json.dumps(_object("foxglove.SceneUpdate", deletions=_ANY, entities=_array(_ENTITY))),
)
