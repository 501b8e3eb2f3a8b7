"""From one entry of `cameras` in a room document to a camera."""

from __future__ import annotations

from typing import cast

import numpy as np

from followspot.errors import Mistake
from followspot.messages import MAX_BYTES, Array
from followspot.room import Camera, LensModel
from followspot.room_document.parts import FAR, TOLERANCE, stage_use, tags_of, word
from followspot.yaml.form import Form, Shape
from followspot.yaml.node import Node

_MAX_SIDE = 1 << 15
_MAX_PIXELS = MAX_BYTES // 3
"""A color picture must fit into a message."""
MOST_FOCAL = 1e6
"""Largest focal length and distance of the principal point, px."""
MOST_DISTORTION = 1e4
_MAX_CLOCK_OFFSET = 1.0
"""Largest absolute clock offset, s; larger ones are mistakes, since offsets are fractions of a frame."""
_KEYS = (
    "kind", "size", "model", "matrix", "distortion", "rotation", "translation", "source", "host",
    "clock_offset", "tags",
)  # fmt: skip
_COEFFICIENTS: dict[str, list[Shape]] = {
    "pinhole": [(5,), (4,)],
    "rational": [(8,)],
    "fisheye": [(4,)],
    "cylinder": [(0,), (5,)],
}


def camera_of(name: str, node: Node, folder: str | None, mistakes: list[Mistake]) -> Camera | None:
    """The camera that an entry describes; None if a mistake leaves it unknown."""
    form = Form(node, f"camera {name}", _KEYS, mistakes)
    kind = word(form, "kind")
    model = form.text("model", choices=tuple(_COEFFICIENTS)) or "pinhole"
    if kind == "depth" and model == "cylinder":
        text = "a depth camera cannot be a cylinder: depth is measured along the optical axis"
        form.wrong(form.entries["model"], text, "model: pinhole, rational, or fisheye")
    size = _size(form)
    matrix = _matrix(form)
    distortion = form.array("distortion", _COEFFICIENTS[model], most=MOST_DISTORTION)
    rotation = _rotation(form)
    translation = form.array("translation", [(3,)], required=True, most=FAR)
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
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > TOLERANCE:
        form.wrong(node, "this is no rotation: its rows are not orthogonal unit vectors", "x_cam = R X + t")
        return None
    if np.linalg.det(rotation) < 0:
        form.wrong(node, "this is no rotation but a reflection: its determinant is -1", "negate one row")
        return None
    return rotation
