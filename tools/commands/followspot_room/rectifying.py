"""`followspot room rectify`: upright cameras without distortion in place of the real ones."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from followspot import Camera
from followspot.errors import InputError, require_unused, writing
from followspot.geometry import ray
from followspot.messages import Array
from followspot.room_file import load, save
from followspot_room.moving import moved
from followspot_room.resized import resized

STEEP = 0.17
"""Angle from the vertical, rad, below which a viewing direction has no upright view."""
LARGEST = 1.6
"""An upright picture is at most so many times as wide and high as the tilted one."""
BORDER = 40
"""Points sampled on each side of a picture to find the extent of its edge."""


def rectify_room(room_file: Path, output: Path, scale: float, *, as_json: bool) -> int:
    """Write a room with upright cameras; returns the exit code. Raises InputError.

    scale: of the new pictures over the old ones.
    """
    require_unused(output, room_file)
    room = load(room_file)
    turned = {name: rectified(camera, scale) for name, camera in room.cameras.items()}
    changed = [name for name, camera in turned.items() if camera is not room.cameras[name]]
    if not changed:
        text = f"{room_file} has no pinhole or fisheye camera with a video that looks at a horizon"
        raise InputError.of(text, "import the room with its videos: followspot room import")
    kept = [name for name in turned if name not in changed]
    targets = {name: resized(target, room.cameras, turned) for name, target in room.targets.items()}
    with writing(output):
        output.parent.mkdir(parents=True, exist_ok=True)
        save(moved(replace(room, name=output.stem, cameras=turned, targets=targets), output), output)
    for name in kept:
        print(f"warning: camera {name} stays as it is", file=sys.stderr)
    sizes = {name: turned[name].size for name in changed}
    if as_json:
        print(json.dumps({"room": output.stem, "cameras": sizes, "kept": kept}))
    else:
        print(f"{output}: " + ", ".join(f"{name} {w}x{h} px" for name, (w, h) in sizes.items()))
    return 0


def rectified(camera: Camera, scale: float) -> Camera:
    """An upright pinhole camera with the same centre, heading and field of view.

    The camera itself if it is no pinhole or fisheye, has no video, or looks up or down.
    """
    ahead = camera.rotation[2]
    source = camera.source
    if source is None or source.uses != "cameras.video" or camera.model == "cylinder":
        return camera
    if np.hypot(*ahead[:2]) < np.sin(STEEP):
        return camera
    right = np.array([ahead[1], -ahead[0], 0.0]) / np.hypot(*ahead[:2])
    rotation = np.stack([right, np.cross(ahead, right), ahead])
    focal = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1])) * scale
    low, high = _extent(camera, rotation, focal, LARGEST * scale * max(camera.size) / 2)
    width, height = (int(side) for side in np.ceil(high - low) + 1)
    lens = {
        "model": camera.model,
        "size": list(camera.size),
        "matrix": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "rotation": camera.rotation.tolist(),
    }
    return replace(
        camera,
        model="pinhole",
        size=(width, height),
        matrix=np.array([[focal, 0, -low[0]], [0, focal, -low[1]], [0, 0, 1]]),
        distortion=np.zeros(5),
        rotation=rotation,
        translation=-rotation @ camera.center,
        source=replace(source, uses="cameras.rectified_video", params={**source.params, "lens": lens}),
    )


def _extent(camera: Camera, rotation: Array, focal: float, limit: float) -> tuple[Array, Array]:
    """Smallest and largest place of the picture's edge before the upright camera, from its axis, px."""
    width, height = camera.size
    t = np.linspace(-0.5, 0.5, BORDER)
    half = np.full(BORDER, 0.5)
    edge = np.concatenate([np.column_stack(side) for side in ((t, half), (t, -half), (half, t), (-half, t))])
    pixel = (edge + 0.5) * [width - 1, height - 1]
    local = ray(camera, pixel) @ rotation.T
    local = local[local[:, 2] > 0]
    place = focal * local[:, :2] / local[:, 2:]
    return np.maximum(place.min(axis=0), -limit), np.minimum(place.max(axis=0), limit)
