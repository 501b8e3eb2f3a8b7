"""Messages in the page's form: JSON types, rounded to display precision."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from followspot.geometry import project
from followspot.inertial import Inertial, PosedTracks
from followspot.messages import Array, Message
from followspot.people import Boxes, Poses, Skeletons, bones_of
from followspot.room import Camera, Room
from followspot.tracking import STATES, Blobs, DepthImage, Forecast, Frame, ImageTracks, Tracks
from followspot_page.display.readings import inertial_view, table_view

SHOWN: tuple[type[Message], ...] = (
    Frame, DepthImage, Blobs, Tracks, Forecast, Poses, Skeletons, Boxes, ImageTracks,
)  # fmt: skip
"""Message types that the page can show from any port; others are shown as readings of a sensor."""
SMOOTH: tuple[type[Message], ...] = (Tracks, Poses, Skeletons, Inertial)
"""Types that are shown more often than pictures."""
_HEAD, _CHEST, _ARROW = 0.115, 0.26, 0.4
"""Radius of a head, m; how far below its top the chest is, as a share of the height; length of arrows, m."""
_SEARCH = 3.0
"""Radius of a drawn search region, in standard deviations of the forecast."""


def view(message: Message, room: Room) -> dict[str, Any]:
    """The data with which the page draws a message; pictures excepted.

    kind: the type as which it is drawn, of which its own may be a subclass.
    """
    drawn = next((kind for kind in type(message).__mro__ if kind in _VIEWS), Message)
    return {
        "kind": drawn.__name__,
        "message": type(message).__name__,
        "time": message.header.time / 1e6,
        "seq": message.header.seq,
        **_VIEWS[drawn](message, room),
    }


def _blobs(m: Blobs, room: Room) -> dict[str, Any]:
    return {
        "camera": m.camera,
        "pixel": _rounded(m.pixel, 1),
        "radius": _rounded(np.sqrt(m.area / math.pi), 1),
        "target": [row.index(True) if row.count(True) == 1 else -1 for row in m.targets.tolist()],
    }


def _tracks(m: Tracks, room: Room) -> dict[str, Any]:
    radii = [target.radius for target in room.targets.values()]
    radius = np.array([radii[i] if 0 <= i < len(radii) else 0.1 for i in m.target])
    return {
        "target": m.target.tolist(),
        "state": [STATES[i] if i < len(STATES) else "" for i in m.state],
        "xyz": _rounded(m.xyz, 4),
        "sigma": _rounded(m.sigma, 4),
        "quaternion": _rounded(m.quaternion, 4) if isinstance(m, PosedTracks) else [],
        "images": _images(room, m.xyz, radius),
    }


def _forecast(m: Forecast, room: Room) -> dict[str, Any]:
    spread = np.sqrt(np.maximum(0.0, np.einsum("tii->ti", m.covariance)).max(1, initial=0.0))
    return {
        "state": [STATES[i] if i < len(STATES) else "" for i in m.state],
        "xyz": _rounded(m.xyz, 4),
        "images": _images(room, m.xyz, _SEARCH * spread),
    }


def _poses(m: Poses, room: Room) -> dict[str, Any]:
    points = _body(m)
    return {
        "camera": m.camera,
        "person": m.person.tolist(),
        "state": [STATES[i] if i < len(STATES) else "" for i in m.state],
        "xy": _rounded(m.xy, 3),
        "height": _rounded(m.height, 3),
        "heading": _rounded(m.heading, 3),
        "pan": _rounded(m.pan, 3),
        "tilt": _rounded(m.tilt, 3),
        "sigma": _rounded(m.sigma[:, :2], 3),
        "images": _images(room, points[:, 0], np.full(len(points), _HEAD)),
        "arrows": {name: _segments(camera, points) for name, camera in room.cameras.items()},
    }


def _body(m: Poses) -> Array:
    """Of each person the head, its viewing direction, the chest, its direction: (M, 4, 3) m."""
    gaze, level = m.heading + m.pan, np.cos(m.tilt)
    face = np.column_stack([level * np.cos(gaze), level * np.sin(gaze), np.sin(m.tilt)])
    front = np.column_stack([np.cos(m.heading), np.sin(m.heading), np.zeros(len(m.heading))])
    head = np.column_stack([m.xy, m.height - _HEAD])
    chest = np.column_stack([m.xy, m.height * (1 - _CHEST)])
    return np.stack([head, head + _ARROW * face, chest, chest + _ARROW * front], axis=1)


def _segments(camera: Camera, points: Array) -> list[list[list[float]] | None]:
    """Images of the ends of lines, one after the other, (M, 2 K, 3) m: px; None if not all are visible."""
    pixel = project(camera, points.reshape(-1, 3)).reshape(*points.shape[:2], 2)
    width, height = camera.size
    near = (np.abs(pixel - [width / 2, height / 2]) < [width, height]).all((1, 2))
    whole = (np.abs(pixel[:, 1::2, 0] - pixel[:, ::2, 0]) < width / 2).all(1)  # none across a panorama's seam
    drawn = np.isfinite(pixel).all((1, 2)) & near & whole
    return [row if ok else None for row, ok in zip(_rounded(pixel, 1), drawn, strict=True)]


def _skeletons(m: Skeletons, room: Room) -> dict[str, Any]:
    ends, person = bones_of(m)
    return {
        "person": person.tolist(),
        "bones": _rounded(ends, 3),
        "images": {name: _segments(camera, ends) for name, camera in room.cameras.items()},
    }


def _boxes(m: Boxes, room: Room) -> dict[str, Any]:
    return {"camera": m.camera, "box": _rounded(m.box, 1), "score": _rounded(m.score, 2)}


def _image_tracks(m: ImageTracks, room: Room) -> dict[str, Any]:
    return {"camera": m.camera, "target": m.target.tolist(), "pixel": _rounded(m.pixel, 1)}


def _images(room: Room, xyz: Array, radius: Array) -> dict[str, list[list[float] | None]]:
    """Images of points in each camera: x, y, radius in px; None if not visible."""
    found = {}
    for name, camera in room.cameras.items():
        pixel = project(camera, xyz)
        distance = np.linalg.norm(xyz - camera.center, axis=1)
        focal = float(abs(camera.matrix[0, 0]))
        size = focal * radius / np.maximum(distance, 1e-6)
        rows = np.column_stack([pixel, size])
        width, height = camera.size
        inside = np.isfinite(rows).all(1) & (pixel >= -50).all(1) & (pixel < [width + 50, height + 50]).all(1)
        found[name] = [row if ok else None for row, ok in zip(_rounded(rows, 1), inside, strict=True)]
    return found


def _rounded(array: Array, digits: int) -> Any:
    """Nested lists; a value that is not finite becomes None, because JSON has no NaN."""
    rounded = np.round(array, digits)
    if np.isfinite(rounded).all():
        return rounded.tolist()
    boxed = rounded.astype(object)
    boxed[~np.isfinite(rounded)] = None
    return boxed.tolist()


_VIEWS: dict[type[Message], Any] = {
    Blobs: _blobs,
    Tracks: _tracks,
    Forecast: _forecast,
    Poses: _poses,
    Skeletons: _skeletons,
    Boxes: _boxes,
    ImageTracks: _image_tracks,
    Inertial: inertial_view,
    Message: table_view,
}
