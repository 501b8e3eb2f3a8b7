"""`--set STAGE.KEY=VALUE`: changes to a graph that is otherwise left as it is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from followspot.document import MAX_DEPTH, Node, parse
from followspot.errors import InputError, Mistake, Place, did_you_mean
from followspot.graph.declaration import ENVELOPE

_FILE = "--set"
_DEEP = ("in", "with")
_FORM = "write STAGE.KEY=VALUE, for example fuse.uses=balls.mean"


@dataclass(frozen=True)
class Override:
    """One option: the keys that lead to a value, each with its place in the option, and the value."""

    keys: tuple[str, ...]
    places: tuple[Place, ...]
    value: Node


def read_override(option: str, mistakes: list[Mistake]) -> Override | None:
    """Read one option; note a mistake if it is malformed."""
    path, sign, value = option.partition("=")
    keys = path.split(".", MAX_DEPTH)
    places = []
    column = 1
    for key in keys:
        places.append(Place(_FILE, 1, column, max(1, len(key)), option))
        column += len(key) + 1
    if not sign or not 2 <= len(keys) <= MAX_DEPTH or not all(key.strip() for key in keys):
        whole = Place(_FILE, 1, 1, max(1, len(option)), option or " ")
        mistakes.append(Mistake(whole, f'"{option}" is no override', _FORM))
        return None
    try:
        # Blanks in front of the value give its places the columns of the option.
        node = parse(" " * (column - 1) + value, _FILE, option)
    except InputError as error:
        mistakes += error.mistakes
        return None
    return Override(tuple(keys), tuple(places), node)


def apply_to_vars(
    values: Mapping[str, Node], overrides: list[Override], mistakes: list[Mistake]
) -> dict[str, Node]:
    """The variables with those of `--set vars.NAME=VALUE`; note a mistake for each unknown variable."""
    changed = dict(values)
    for override in overrides:
        group, name = override.keys[0], ".".join(override.keys[1:])
        if group == "vars" and name in values:
            changed[name] = override.value
        elif group == "vars":
            remedy = did_you_mean(name, values, "vars")
            mistakes.append(Mistake(override.places[1], f'the graph has no variable "{name}"', remedy))
    return changed


def apply_to_stages(
    stages: Mapping[str, Node], overrides: list[Override], mistakes: list[Mistake]
) -> dict[str, Node]:
    """The stages with every override in its place; one for an unknown stage is noted."""
    changed = dict(stages)
    for override in overrides:
        name, *keys = override.keys
        if name == "vars":
            continue
        if name not in changed:
            remedy = did_you_mean(name, stages, "stages")
            mistakes.append(Mistake(override.places[0], f'the graph has no stage "{name}"', remedy))
            continue
        places = override.places[1:]
        if keys[0] not in ENVELOPE:  # a parameter
            keys, places = ["with", *keys], (places[0], *places)
        elif keys[0] in _DEEP and len(keys) == 1:
            text = f'"{keys[0]}" holds several values'
            mistakes.append(Mistake(places[0], text, f"name one: {name}.{keys[0]}.NAME=VALUE"))
            continue
        changed[name] = _with(changed[name], keys, places, override.value)
    return changed


def _with(node: Node, keys: list[str], places: tuple[Place, ...], value: Node) -> Node:
    """The tree with a value put under a path of keys."""
    if not keys:
        return replace(value, key=node.key)
    inner = dict(node.value) if isinstance(node.value, Mapping) else {}
    old = inner.get(keys[0], Node(None, places[0], places[0]))
    inner[keys[0]] = _with(replace(old, key=places[0]), keys[1:], places[1:], value)
    return replace(node, value=inner)
