"""What viewers know (Foxglove's schemas in JSON) of frames, tracks, poses and log lines."""

from __future__ import annotations

import json
import math
from base64 import b64encode
from collections.abc import Iterable
from typing import Any, Literal

import cv2
import numpy as np

from followspot import Message, Room
from followspot.messages import Array
from followspot.people import Poses, PoseTruth
from followspot.tracking import Frame, Tracks, Truth
from followspot_recording.recorder import Schema

Pictures = Literal["jpeg", "png", "raw", "none"]
ROOM_FRAME = "room"
_INFO = 2
_JPEG_QUALITY = 90
_LIFETIME = {"sec": 0, "nsec": 250_000_000}
"""A sphere that is not renewed in this time vanishes: the target is lost."""
_LOOKS = {"tracked": (0.1, 0.8, 0.2, 1.0)}
_OTHER_LOOK = (0.9, 0.6, 0.1, 0.5)


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
SCENE_UPDATE = Schema(
    "foxglove.SceneUpdate",
    "jsonschema",
    json.dumps(_object("foxglove.SceneUpdate", deletions=_ANY, entities=_array(_ENTITY))),
)


def view_of(message: Message, room: Room, pictures: Pictures) -> tuple[Schema, bytes] | None:
    """Schema and JSON of what a viewer is shown of a message; None where viewers know nothing like it."""
    if isinstance(message, Frame):
        return None if pictures == "none" else _picture(message, pictures)
    if isinstance(message, Tracks):
        return SCENE_UPDATE, _spheres(message, room)
    if isinstance(message, Poses | PoseTruth):
        xyz = np.column_stack([message.xy, message.height])
        return POSES_IN_FRAME, _poses(message, xyz, message.heading)
    if isinstance(message, Truth):
        return POSES_IN_FRAME, _poses(message, message.xyz, np.zeros(len(message.xyz)))
    return None


def log_line(time: int, text: str) -> bytes:
    """A foxglove.Log of level "info"; time: ns."""
    line = {"timestamp": _time(time), "level": _INFO, "message": text, "name": "followspot"}
    return _json(line | {"file": "", "line": 0})


def _picture(frame: Frame, pictures: Pictures) -> tuple[Schema, bytes]:
    pixels = frame.pixels
    height, width, channels = pixels.shape
    head = {"timestamp": _time(frame.header.time), "frame_id": frame.camera}
    if pictures == "raw" or not pixels.size or channels not in (1, 3):
        encoding = {1: "mono8", 3: "bgr8"}.get(channels, f"8UC{channels}")
        size = {"width": width, "height": height, "encoding": encoding, "step": width * channels}
        return RAW_IMAGE, _json(head | size | {"data": _base64(pixels)})
    quality = (cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY) if pictures == "jpeg" else ()
    _, packed = cv2.imencode(".jpg" if pictures == "jpeg" else ".png", pixels, quality)
    return COMPRESSED_IMAGE, _json(head | {"format": pictures, "data": _base64(packed)})


def _spheres(tracks: Tracks, room: Room) -> bytes:
    targets = list(room.targets.values())
    entities = []
    for index, state, xyz in zip(tracks.target, tracks.state, tracks.xyz.tolist(), strict=True):
        known = 0 <= index < len(targets)
        name = targets[index].name if known else f"target {index}"
        if _finite(xyz):
            size = 2.0 * (targets[index].radius if known else 0.05)
            entities.append(_entity(tracks.header.time, name, xyz, size, state == 1))
    return _json({"deletions": [], "entities": entities})


def _entity(time: int, name: str, xyz: list[float], size: float, tracked: bool) -> dict[str, Any]:
    """A target as a sphere of its diameter, m, with its name above it."""
    color = dict(zip("rgba", _LOOKS["tracked"] if tracked else _OTHER_LOOK, strict=True))
    sphere = {"pose": _pose(xyz), "size": {"x": size, "y": size, "z": size}, "color": color}
    above = _pose([xyz[0], xyz[1], xyz[2] + size])
    label = {"pose": above, "billboard": True, "font_size": 12.0, "scale_invariant": True}
    nothing: dict[str, Any] = {
        key: [] for key in ("metadata", "arrows", "cubes", "cylinders", "lines", "triangles", "models")
    }
    return nothing | {
        "timestamp": _time(time),
        "frame_id": ROOM_FRAME,
        "id": name,
        "lifetime": _LIFETIME,
        "frame_locked": False,
        "spheres": [sphere],
        "texts": [label | {"color": color, "text": name}],
    }


def _poses(message: Message, xyz: Array, heading: Array) -> bytes:
    """xyz: (M, 3) m; heading: (M,) rad, about the vertical axis. Rows that are not known are left out."""
    rows: Iterable[tuple[list[float], float]] = zip(xyz.tolist(), heading.tolist(), strict=True)
    poses = [_pose(place, turn) for place, turn in rows if _finite([*place, turn])]
    return _json({"timestamp": _time(message.header.time), "frame_id": ROOM_FRAME, "poses": poses})


def _pose(xyz: list[float], heading: float = 0.0) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)}
    return {"position": dict(zip("xyz", xyz, strict=True)), "orientation": turn}


def _time(time: int) -> dict[str, int]:
    seconds, rest = divmod(max(0, time), 1_000_000_000)
    return {"sec": seconds, "nsec": rest}


def _finite(numbers: list[float]) -> bool:
    return all(map(math.isfinite, numbers))


def _base64(array: Array) -> str:
    return b64encode(array.data).decode("ascii")


def _json(data: dict[str, Any]) -> bytes:
    return json.dumps(data, allow_nan=False, separators=(",", ":")).encode()
