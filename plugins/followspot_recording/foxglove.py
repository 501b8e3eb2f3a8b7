"""Frames, points, tracks, poses and log lines for viewers, in Foxglove's schemas as JSON."""

from __future__ import annotations

import json
import math
from base64 import b64encode
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any, Literal

import cv2
import numpy as np

from followspot import Message, Room
from followspot.frame_times import SECOND
from followspot.messages import Array
from followspot.people import Poses, PoseTruth
from followspot.room import Camera
from followspot.rotation import from_rotation_vector
from followspot.tracking import TRACKED, Frame, Tracks, Truth
from followspot_recording.recorder import Schema
from followspot_recording.schemas import (
    CAMERA_CALIBRATION,
    COMPRESSED_IMAGE,
    FRAME_TRANSFORM,
    IMAGE_ANNOTATIONS,
    POINT_CLOUD,
    POSES_IN_FRAME,
    RAW_IMAGE,
    SCENE_UPDATE,
)

Pictures = Literal["jpeg", "png", "raw", "none"]
ROOM_FRAME = "room"
_INFO = 2
"""Foxglove's number of the level of a log line."""
_JPEG_QUALITY = 90
_LIFETIME = {"sec": 0, "nsec": 250_000_000}
"""A sphere that is not renewed in this time vanishes: the target is lost."""
_TRACKED_COLOR, _OTHER_COLOR = (0.1, 0.8, 0.2, 1.0), (0.9, 0.6, 0.1, 0.5)
"""RGBA of a target that is tracked, and of one in another state."""
_UNKNOWN_RADIUS = 0.05
"""Radius of a target that the room does not have, m."""
_POINTS, _FLOAT32 = 1, 7
"""Foxglove's numbers of points that stand alone, and of a type of number."""
_MARK = {"r": 1.0, "g": 0.9, "b": 0.1, "a": 1.0}
_MARK_SIZE = 4.0
"""Of a point in a picture, px."""
_LENSES = {"pinhole": "plumb_bob", "rational": "rational_polynomial", "fisheye": "kannala_brandt"}
"""Foxglove's names of our lenses."""


def view_of(message: Message, room: Room, pictures: Pictures) -> tuple[Schema, bytes] | None:
    """Schema and JSON of a message for viewers; None if they have no schema for it."""
    if isinstance(message, Frame):
        return None if pictures == "none" else _picture(message, pictures)
    if isinstance(message, Tracks):
        return SCENE_UPDATE, _spheres(message, room)
    if isinstance(message, Poses | PoseTruth):
        xyz = np.column_stack([message.xy, message.height])
        return POSES_IN_FRAME, _poses(message, xyz, message.heading)
    if isinstance(message, Truth):
        return POSES_IN_FRAME, _poses(message, message.xyz, np.zeros(len(message.xyz)))
    kind: Any = type(message)
    if _has(kind, "pixel", 2):
        return IMAGE_ANNOTATIONS, _marks(message.header.time, message.__dict__["pixel"])
    if _has(kind, "xyz", 3):
        return POINT_CLOUD, _cloud(message.header.time, message.__dict__["xyz"])
    return None


def cameras_of(room: Room, time: int) -> Iterator[tuple[str, Schema, bytes]]:
    """Topic, schema and JSON of where each camera of a room stands, and of its lens; time: ns.

    A panorama has no lens that Foxglove knows, and only its place is shown.
    """
    for camera in room.cameras.values():
        topic = f"/cameras/{camera.name}"
        yield f"{topic}/transform", FRAME_TRANSFORM, _placement(camera, time)
        if camera.model in _LENSES:
            yield f"{topic}/calibration", CAMERA_CALIBRATION, _lens(camera, time)


def _placement(camera: Camera, time: int) -> bytes:
    """From the camera's coordinates, x_cam = R X + t, to those of the room."""
    vector, _ = cv2.Rodrigues(camera.rotation.T)
    turn = dict(zip("wxyz", from_rotation_vector(vector.ravel()).tolist(), strict=True))
    frames = {"parent_frame_id": ROOM_FRAME, "child_frame_id": camera.name}
    place = {"translation": dict(zip("xyz", camera.center.tolist(), strict=True)), "rotation": turn}
    return _json({"timestamp": _time(time), **frames, **place})


def _lens(camera: Camera, time: int) -> bytes:
    width, height = camera.size
    matrix = camera.matrix
    matrices = {"K": matrix, "R": np.eye(3), "P": np.column_stack([matrix, np.zeros(3)])}
    about = {"timestamp": _time(time), "frame_id": camera.name, "width": width, "height": height}
    lens = {"distortion_model": _LENSES[camera.model], "D": camera.distortion.tolist()}
    return _json(about | lens | {name: found.ravel().tolist() for name, found in matrices.items()})


@cache
def _has(kind: Any, name: str, size: int) -> bool:
    """Whether messages of a type have a column of points, (N, size)."""
    return any(column.name == name and column.shape[1:] == (size,) for column in kind.columns)


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
            size = 2.0 * (targets[index].radius if known else _UNKNOWN_RADIUS)
            entities.append(_entity(tracks.header.time, name, xyz, size, state == TRACKED))
    return _json({"deletions": [], "entities": entities})


def _entity(time: int, name: str, xyz: list[float], size: float, tracked: bool) -> dict[str, Any]:
    """A target as a sphere of its diameter, m, with its name above it."""
    color = dict(zip("rgba", _TRACKED_COLOR if tracked else _OTHER_COLOR, strict=True))
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


def _cloud(time: int, xyz: Array) -> bytes:
    """xyz: (N, 3) m. Rows that are not known are left out."""
    packed = np.ascontiguousarray(_known(xyz), "<f4")
    fields = [{"name": axis, "offset": 4 * i, "type": _FLOAT32} for i, axis in enumerate("xyz")]
    about = {"timestamp": _time(time), "frame_id": ROOM_FRAME, "pose": _pose([0.0, 0.0, 0.0])}
    return _json(about | {"point_stride": 12, "fields": fields, "data": _base64(packed)})


def _marks(time: int, pixel: Array) -> bytes:
    """pixel: (N, 2) px, as they stand in the picture. Rows that are not known are left out."""
    points = [{"x": x, "y": y} for x, y in _known(pixel).tolist()]
    looks = {"outline_color": _MARK, "outline_colors": [], "fill_color": _MARK, "thickness": _MARK_SIZE}
    marks = {"timestamp": _time(time), "type": _POINTS, "points": points, **looks, "metadata": []}
    return _json({"timestamp": _time(time), "circles": [], "points": [marks], "texts": [], "metadata": []})


def _known(points: Array) -> Array:
    """(N, D) without the rows that are not known."""
    return points[np.isfinite(points).all(axis=1)]


def _poses(message: Message, xyz: Array, heading: Array) -> bytes:
    """xyz: (M, 3) m; heading: (M,) rad, about the vertical axis. Rows that are not known are left out."""
    rows: Iterable[tuple[list[float], float]] = zip(xyz.tolist(), heading.tolist(), strict=True)
    poses = [_pose(place, turn) for place, turn in rows if _finite([*place, turn])]
    return _json({"timestamp": _time(message.header.time), "frame_id": ROOM_FRAME, "poses": poses})


def _pose(xyz: list[float], heading: float = 0.0) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)}
    return {"position": dict(zip("xyz", xyz, strict=True)), "orientation": turn}


def _time(time: int) -> dict[str, int]:
    seconds, rest = divmod(max(0, time), SECOND)
    return {"sec": seconds, "nsec": rest}


def _finite(numbers: list[float]) -> bool:
    return all(map(math.isfinite, numbers))


def _base64(array: Array) -> str:
    return b64encode(array.data).decode("ascii")


def _json(data: dict[str, Any]) -> bytes:
    return json.dumps(data, allow_nan=False, separators=(",", ":")).encode()
