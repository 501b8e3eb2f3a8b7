"""From a room document to a room, with every mistake at its line and column."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from followspot.document import Node
from followspot.errors import InputError, Mistake
from followspot.form import Form, Shape, is_name
from followspot.messages import MAX_BYTES, Array
from followspot.room import Camera, LensModel, Room, Target
from followspot.room_parts import stage_use, tags_of, word
from followspot.sensor_form import sensor_of
from followspot.sync_form import sync_of
from followspot.tune_form import tune_of

BINS = 16
"""Bins of a hue histogram (Jin & Qian 2008, section 2.1)."""
MAX_CAMERAS = 1000
MAX_SENSORS = 1000
MAX_TARGETS = 1000
MAX_PLANES = 1000
_TOLERANCE = 1e-3
"""Largest deviation of R R^T from the identity, and of a plane's normal from unit length."""
_ROUNDING = 1e-9
"""Deviation from a unit sum or length that is not corrected: a written room is read back bit for bit."""
_MAX_SIDE = 1 << 15
_MAX_PIXELS = MAX_BYTES // 3
"""A color picture must fit into a message."""
_FAR = 1e6
"""Largest length of anything in a room, m."""
MOST_FOCAL = 1e6
"""Largest focal length and distance of the principal point, px."""
MOST_DISTORTION = 1e4
_MOST_AREA = 1e9
"""Largest area of a target in a picture, px."""
_MAX_CLOCK_OFFSET = 1.0
"""Largest absolute clock offset, s; larger ones are mistakes, since offsets are fractions of a frame."""
_KEYS = ("room", "cameras", "sensors", "planes", "targets", "truth", "tune", "sync")
_CAMERA_KEYS = (
    "kind", "size", "model", "matrix", "distortion", "rotation", "translation", "source", "host",
    "clock_offset", "tags",
)  # fmt: skip
_TARGET_KEYS = ("radius", "hue_histogram", "area", "gray", "tags")
_COEFFICIENTS: dict[str, list[Shape]] = {
    "pinhole": [(5,), (4,)],
    "rational": [(8,)],
    "fisheye": [(4,)],
    "cylinder": [(0,), (5,)],
}


def room_of(root: Node, folder: str | None) -> Room:
    """The room that a document describes. Raises InputError with every mistake.

    folder: that paths in the document are relative to; None if each source has its own.
    """
    mistakes: list[Mistake] = []
    form = Form(root, "a room", _KEYS, mistakes)
    name = form.title("room") or "room"
    cameras = _cameras(form, folder)
    sensors = {
        key: sensor_of(key, node, form, folder) for key, node in _named(form, "sensors", MAX_SENSORS).items()
    }
    planes = {key: _plane(form, key, node) for key, node in _named(form, "planes", MAX_PLANES).items()}
    names = form.mapping("cameras")
    targets = {
        key: _target(key, node, names, mistakes) for key, node in _named(form, "targets", MAX_TARGETS).items()
    }
    truth = form.get("truth")
    use = None if truth is None else stage_use(truth, "truth", folder, mistakes)
    tune = tune_of(form)
    sync = sync_of(form, names)
    if mistakes:
        raise InputError(mistakes)
    return Room(
        name=name,
        cameras=cameras,
        planes=planes,
        targets=targets,
        truth=use,
        sensors=sensors,
        tune=tune,
        sync=sync,
    )


def _named(form: Form, key: str, most: int) -> Mapping[str, Node]:
    """The entries of a section; notes mistakes in their names."""
    entries = form.mapping(key)
    if len(entries) > most:
        form.wrong(form.entries[key], f"{len(entries)} {key}, at most {most} are allowed")
        return {}
    for name, node in entries.items():
        if not is_name(name):
            form.mistakes.append(
                Mistake(node.key, f'"{name}" cannot be a name', "use 1 to 100 letters, digits, _ and -")
            )
    return entries


def _cameras(form: Form, folder: str | None) -> dict[str, Camera]:
    found = {
        name: _camera(name, node, folder, form.mistakes)
        for name, node in _named(form, "cameras", MAX_CAMERAS).items()
    }
    return {name: camera for name, camera in found.items() if camera is not None}


def _camera(name: str, node: Node, folder: str | None, mistakes: list[Mistake]) -> Camera | None:
    """The camera that an entry describes; None if a mistake leaves it unknown."""
    form = Form(node, f"camera {name}", _CAMERA_KEYS, mistakes)
    kind = word(form, "kind")
    model = form.text("model", choices=tuple(_COEFFICIENTS)) or "pinhole"
    if kind == "depth" and model == "cylinder":
        text = "a depth camera cannot be a cylinder: depth is measured along the optical axis"
        form.wrong(form.entries["model"], text, "model: pinhole, rational, or fisheye")
    size = _size(form)
    matrix = _matrix(form)
    distortion = form.array("distortion", _COEFFICIENTS[model], most=MOST_DISTORTION)
    rotation = _rotation(form)
    translation = form.array("translation", [(3,)], required=True, most=_FAR)
    source = form.get("source")
    use = None if source is None else stage_use(source, f"the source of {name}", folder, mistakes)
    host = form.host()
    clock_offset = form.number("clock_offset", least=-_MAX_CLOCK_OFFSET, most=_MAX_CLOCK_OFFSET) or 0.0
    tags = tags_of(form)
    if kind is None or size is None or matrix is None or rotation is None or translation is None:
        return None
    if distortion is None:
        distortion = np.zeros(_COEFFICIENTS[model][0])
    elif model == "pinhole":
        distortion = np.pad(distortion, (0, 5 - len(distortion)))
    return Camera(
        name=name,
        kind=kind,
        size=size,
        matrix=matrix,
        distortion=distortion,
        rotation=rotation,
        translation=translation,
        model=cast(LensModel, model),
        source=use,
        host=host,
        clock_offset=clock_offset,
        tags=tags,
    )


def _size(form: Form) -> tuple[int, int] | None:
    """Width and height, px; None if they are wrong or missing."""
    size = form.array("size", [(2,)], required=True)
    if size is None:
        return None
    if not ((size >= 1).all() and (size <= _MAX_SIDE).all() and (size % 1 == 0).all()):
        text = "size is the width and height in whole pixels"
        form.wrong(form.entries["size"], text, f"each from 1 to {_MAX_SIDE}")
        return None
    if size.prod() > _MAX_PIXELS:
        text = f"{size[0]:g} x {size[1]:g} pixels do not fit into a message"
        form.wrong(form.entries["size"], text, f"at most {_MAX_PIXELS} pixels")
        return None
    return int(size[0]), int(size[1])


def _matrix(form: Form) -> Array | None:
    """The camera matrix, (3, 3) px; None if it is wrong or missing."""
    matrix = form.array("matrix", [(3, 3)], required=True, most=MOST_FOCAL)
    if matrix is None:
        return None
    if not (matrix[0, 0] > 0 and matrix[1, 1] > 0 and matrix[1, 0] == 0 and (matrix[2] == [0, 0, 1]).all()):
        form.wrong(
            form.entries["matrix"],
            "this is no camera matrix",
            "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]] with positive fx and fy, px",
        )
        return None
    return matrix


def _rotation(form: Form) -> Array | None:
    """The rotation, (3, 3); None if it is wrong or missing."""
    rotation = form.array("rotation", [(3, 3)], required=True)
    if rotation is None:
        return None
    node = form.entries["rotation"]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > _TOLERANCE:
        form.wrong(node, "this is no rotation: its rows are not orthogonal unit vectors", "x_cam = R X + t")
        return None
    if np.linalg.det(rotation) < 0:
        form.wrong(node, "this is no rotation but a reflection: its determinant is -1", "negate one row")
        return None
    return rotation


def _plane(form: Form, name: str, node: Node) -> Array:
    """The plane, (4,), with unit normal; zeros if it cannot be read."""
    plane = form.numbers(node, f"plane {name}", [(4,)], most=_FAR)
    if plane is None:
        return np.zeros(4)
    length = float(np.linalg.norm(plane[:3]))
    if abs(length - 1.0) > _TOLERANCE:
        remedy = (
            "divide all four numbers by it" if length > 0 else "a x + b y + c z + d = 0 with a unit normal, m"
        )
        form.wrong(node, f"the normal of plane {name} has length {length:.6g}, not 1", remedy)
        return plane
    return plane if abs(length - 1.0) < _ROUNDING else plane / length


def _target(name: str, node: Node, cameras: Mapping[str, Node], mistakes: list[Mistake]) -> Target:
    form = Form(node, f"target {name}", _TARGET_KEYS, mistakes)
    radius = form.number("radius", above=0.0, most=_FAR, required=True)
    histograms = {
        camera: _histogram(form, camera, values)
        for camera, values in _per_camera(form, "hue_histogram", (BINS,), cameras, 1e9).items()
    }
    area, gray = _ranges(form, "area", cameras), _ranges(form, "gray", cameras)
    return Target(name, radius or 1.0, histograms, area, gray, tags_of(form))


def _histogram(form: Form, camera: str, values: Array) -> Array:
    total = float(values.sum())
    if values.min() < 0 or total <= 0:
        problem = "a bin below 0" if values.min() < 0 else "no bin above 0"
        form.wrong(form.mapping("hue_histogram")[camera], f"the hue histogram for {camera} has {problem}")
        return values
    return values if abs(total - 1.0) < _ROUNDING else values / total


def _ranges(form: Form, key: str, cameras: Mapping[str, Node]) -> dict[str, tuple[float, float]]:
    ranges = {}
    for camera, (low, high) in _per_camera(form, key, (2,), cameras, _MOST_AREA).items():
        if low > high or low < 0:
            node = form.mapping(key)[camera]
            form.wrong(node, f"{key} for {camera} cannot be [{low:g}, {high:g}]", "write [smallest, largest]")
        ranges[camera] = (float(low), float(high))
    return ranges


def _per_camera(
    form: Form, key: str, shape: Shape, cameras: Mapping[str, Node], most: float
) -> dict[str, Array]:
    found = {}
    for camera, node in form.mapping(key).items():
        if camera not in cameras:
            form.unknown(node, f'the room has no camera "{camera}"', camera, cameras, "cameras")
        values = form.numbers(node, f"{key} for {camera}", [shape], most=most)
        if values is not None:
            found[camera] = values
    return found
