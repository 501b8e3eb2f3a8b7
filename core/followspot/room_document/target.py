"""From one entry of `targets` in a room document to a target."""

from __future__ import annotations

from collections.abc import Mapping

from followspot.errors import Mistake
from followspot.messages import Array
from followspot.room import Target
from followspot.room_document.parts import FAR, ROUNDING, tags_of
from followspot.yaml.form import Form, Shape
from followspot.yaml.node import Node

BINS = 16
"""Bins of a hue histogram (Jin & Qian 2008, section 2.1)."""
_MOST_AREA = 1e9
"""Largest area of a target in a picture, px."""
_KEYS = ("radius", "hue_histogram", "area", "gray", "tags")


def target_of(name: str, node: Node, cameras: Mapping[str, Node], mistakes: list[Mistake]) -> Target:
    """The target that an entry describes; notes mistakes. cameras: the entries of all cameras."""
    form = Form(node, f"target {name}", _KEYS, mistakes)
    radius = form.number("radius", above=0.0, most=FAR, required=True)
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
    return values if abs(total - 1.0) < ROUNDING else values / total


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
