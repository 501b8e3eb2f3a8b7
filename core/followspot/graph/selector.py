"""`each: cameras[kind=color, name=cam0|cam1]`: which cameras of the room a stage fans out over."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from followspot.document import Node
from followspot.errors import Mistake, Place, did_you_mean
from followspot.form import kind_of
from followspot.room import Camera

PROPERTIES = ("name", "kind", "model", "host")
"""Properties of a camera that a selector may ask for."""
_FORM = re.compile(r"cameras\s*(?:\[(.*)\])?", re.DOTALL)


@dataclass(frozen=True)
class Selector:
    """Conditions that all must hold: property -> allowed values."""

    conditions: Mapping[str, frozenset[str]]
    text: str
    place: Place

    def select(self, cameras: Mapping[str, Camera]) -> list[str]:
        """Names of the cameras that fit, in the order of the room."""
        return [
            name
            for name, camera in cameras.items()
            if all(getattr(camera, key) in allowed for key, allowed in self.conditions.items())
        ]


def read_selector(node: Node, mistakes: list[Mistake]) -> Selector:
    """Read the value of `each`; a selector that cannot be read is noted and takes every camera."""
    found = _FORM.fullmatch(node.value.strip()) if isinstance(node.value, str) else None
    if found is None:
        text = f"each cannot be {kind_of(node)}"
        mistakes.append(Mistake(node.place, text, 'write cameras, or "cameras[kind=color]"'))
        return Selector({}, "cameras", node.place)
    conditions: dict[str, frozenset[str]] = {}
    for part in filter(str.strip, (found[1] or "").split(",")):
        key, sign, value = (piece.strip() for piece in part.partition("="))
        if not sign:
            mistakes.append(Mistake(node.place, f'"{part.strip()}" is no condition', "write PROPERTY=VALUE"))
        elif key not in PROPERTIES:
            remedy = did_you_mean(key, PROPERTIES, "properties")
            mistakes.append(Mistake(node.place, f'cameras have no property "{key}"', remedy))
        else:
            conditions[key] = frozenset(choice.strip() for choice in value.split("|"))
    return Selector(conditions, str(node.value), node.place)
