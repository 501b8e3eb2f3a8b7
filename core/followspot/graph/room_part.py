"""A part of a room: some of its cameras, and the parts of its targets that belong to these."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

from followspot.errors import Mistake, Place, did_you_mean
from followspot.yaml.node import Node, child

_BY_CAMERA = ("hue_histogram", "area", "gray")
"""Keys of a target that have a value for each camera."""


def part_of(room: Node, cameras: Sequence[str], mistakes: list[Mistake]) -> Node:
    """The document of a room with these cameras only; notes those that it does not have.

    If it lacks any, the room stays whole, so that no other mistakes follow from that.
    The templates of the other cameras go with them, and so do parameters that are tuned for them alone.
    """
    known = _entries(child(room, "cameras"))
    for name in cameras:
        if name not in known:
            place = Place("--cameras", 1, 1, max(1, len(name)), name)
            remedy = did_you_mean(name, known, "cameras")
            mistakes.append(Mistake(place, f'the room has no camera "{name}"', remedy))
    if not known.keys() >= set(cameras):
        return room
    others = known.keys() - set(cameras)

    def target(node: Node) -> Node:
        return _changed(node, _BY_CAMERA, lambda by_camera: _without(by_camera, others))

    def targets(node: Node) -> Node:
        return _changed(node, _entries(node), target)

    def tune(node: Node) -> Node:
        return _without(node, [key for key in _entries(node) if _camera_of(key) in others])

    room = _changed(room, ["cameras"], lambda node: _without(node, others))
    return _changed(_changed(room, ["targets"], targets), ["tune"], tune)


def _camera_of(tune: str) -> str:
    """The member that a tuned parameter, STAGE/MEMBER.PARAMETER, is for; "" if it is for all."""
    stage, _, _ = tune.partition(".")
    return stage.rpartition("/")[2] if "/" in stage else ""


def _entries(node: Node | None) -> Mapping[str, Node]:
    return node.value if node is not None and isinstance(node.value, Mapping) else {}


def _changed(node: Node, keys: Collection[str], change: Callable[[Node], Node]) -> Node:
    """The mapping with the values of these keys changed, as far as it has them."""
    new = {key: change(value) for key, value in _entries(node).items() if key in keys}
    return replace(node, value={**_entries(node), **new}) if new else node


def _without(node: Node, keys: Collection[str]) -> Node:
    kept = {key: value for key, value in _entries(node).items() if key not in keys}
    return replace(node, value=kept) if _entries(node) else node
