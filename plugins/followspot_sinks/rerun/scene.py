"""Messages as the Rerun viewer shows them. The caller imports `rerun`, which is an optional extra."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from followspot import Message, Room
from followspot.inertial import PosedTracks
from followspot.messages import Array
from followspot.people import Poses, PoseTruth, Skeletons, bones_of
from followspot.rotation import matrix
from followspot.tracking import STATES, TRACKED, Frame, Tracks, Truth

ROOT = "room"
_JPEG_QUALITY = 85
_RADIUS = 0.02
"""Radius of points in the room whose size is unknown, m."""
_BONE = 0.01
"""Radius of the bones of a skeleton, m."""
_HEADING = 0.4
"""Length of the arrow of a chest's heading, m."""
_AXIS = 0.2
"""Length of the arrow of an axis, m."""
SIGMAS = 3.0
"""Half an axis of the ellipsoid of uncertainty, in standard deviations."""


def entity_of(message: Message, name: str) -> str:
    """The entity in the viewer's tree: messages of a camera are below the camera."""
    camera = getattr(message, "camera", "")
    if not camera or isinstance(message, Poses):
        return f"{ROOT}/{name}"
    return f"{ROOT}/{camera}" if isinstance(message, Frame) else f"{ROOT}/{camera}/{name}"


def shape_of(rerun: Any, message: Message, room: Room) -> Any:
    """The message as an archetype of the `rerun` module; None if there is none for its type."""
    if isinstance(message, Frame):
        return _picture(rerun, message)
    if isinstance(message, Poses | PoseTruth):
        return _persons(rerun, message)
    if isinstance(message, Tracks):
        return _targets(rerun, message, room)
    if isinstance(message, Truth):
        return rerun.Points3D(message.xyz, radii=_RADIUS, labels=list(message.objects))
    columns = {column.name: column.shape for column in message.columns}
    if columns.get("xyz", ())[1:] == (3,):
        return rerun.Points3D(_known(message.__dict__["xyz"]), radii=_RADIUS)
    if columns.get("pixel", ())[1:] == (2,):
        return rerun.Points2D(_known(message.__dict__["pixel"]))
    return None


def parts_of(rerun: Any, message: Message) -> dict[str, Any]:
    """Further shapes of a message, by the name of their entity: uncertainty and axes of tracks, bones."""
    if isinstance(message, Skeletons):
        ends, _ = bones_of(message)
        return {"bones": rerun.LineStrips3D(strips=ends[np.isfinite(ends).all(axis=(1, 2))], radii=_BONE)}
    if not isinstance(message, Tracks):
        return {}
    parts = {"uncertainty": _uncertainty(rerun, message)}
    return {**parts, "axes": _axes(rerun, message)} if isinstance(message, PosedTracks) else parts


def log_cameras(rerun: Any, stream: Any, room: Room) -> None:
    """Poses and fields of view of the room's cameras, once for the whole recording."""
    stream.log(ROOT, rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for camera in room.cameras.values():
        place = rerun.Transform3D(translation=camera.center, mat3x3=camera.rotation.T)
        stream.log(f"{ROOT}/{camera.name}", place, static=True)
        if camera.model in ("pinhole", "rational"):
            lens = rerun.Pinhole(image_from_camera=camera.matrix, resolution=camera.size)
            stream.log(f"{ROOT}/{camera.name}", lens, static=True)


def _picture(rerun: Any, frame: Frame) -> Any:
    if not frame.pixels.size or frame.pixels.shape[2] not in (1, 3):
        return rerun.Clear(recursive=False)
    _, packed = cv2.imencode(".jpg", frame.pixels, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    return rerun.EncodedImage(contents=packed.tobytes(), media_type="image/jpeg")


def _targets(rerun: Any, tracks: Tracks, room: Room) -> Any:
    known = np.isfinite(tracks.xyz).all(axis=1)
    targets = list(room.targets.values())
    radii, labels = [], []
    for index, state in zip(tracks.target[known].tolist(), tracks.state[known].tolist(), strict=True):
        target = targets[index] if 0 <= index < len(targets) else None
        radii.append(target.radius if target else _RADIUS)
        name = target.name if target else f"target {index}"
        labels.append(
            name if state == TRACKED else f"{name} ({STATES[state] if state < len(STATES) else state})"
        )
    return rerun.Points3D(tracks.xyz[known], radii=radii, labels=labels)


def _uncertainty(rerun: Any, tracks: Tracks) -> Any:
    """An ellipsoid of three sigma about each target whose uncertainty is known."""
    known = np.isfinite(np.hstack([tracks.xyz, tracks.sigma])).all(axis=1)
    return rerun.Ellipsoids3D(centers=tracks.xyz[known], half_sizes=SIGMAS * tracks.sigma[known])


def _axes(rerun: Any, tracks: PosedTracks) -> Any:
    """The axes x, y and z of each target whose orientation is known, in red, green and blue."""
    known = np.isfinite(np.hstack([tracks.xyz, tracks.quaternion])).all(axis=1)
    axes = np.swapaxes(matrix(tracks.quaternion[known]), 1, 2).reshape(-1, 3)
    return rerun.Arrows3D(
        origins=np.repeat(tracks.xyz[known], 3, axis=0),
        vectors=_AXIS * axes,
        colors=np.tile(255 * np.eye(3, dtype="u1"), (int(known.sum()), 1)),
    )


def _persons(rerun: Any, poses: Poses | PoseTruth) -> Any:
    heads = np.column_stack([poses.xy, poses.height])
    known = np.isfinite(heads).all(axis=1) & np.isfinite(poses.heading)
    heading = poses.heading[known]
    arrows = _HEADING * np.column_stack([np.cos(heading), np.sin(heading), np.zeros(len(heading))])
    labels = [f"person {number}" for number in poses.person[known].tolist()]
    return rerun.Arrows3D(origins=heads[known], vectors=arrows, labels=labels)


def _known(points: Array) -> Array:
    """(N, D) without the rows that are not known."""
    return points[np.isfinite(points).all(axis=1)]
