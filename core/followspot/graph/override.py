"""`--set STAGE.KEY=VALUE`: changes to a graph that is otherwise left as it is written."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from followspot.errors import FollowspotError, InputError, Mistake, Place
from followspot.stage_params import ENVELOPE
from followspot.yaml.node import MAX_DEPTH, Node, child
from followspot.yaml.reader import parse

SUBGRAPH = ("graph", "cameras", "each", "optional", "with", "in")
"""Keys of a stage that is a sub-graph."""
_FILE = "--set"
WHILE_IT_RAN = "(set while it ran)"
"""Stands for the file of values that a change gave while the graph ran; files that come later get them."""
_DEEP = ("in", "with")
_FORM = "write STAGE.KEY=VALUE, for example fuse.uses=balls.mean"


@dataclass(frozen=True)
class Override:
    """One option: the stage, the keys that lead to a value, each with its place in the option, and the value.

    within: the sub-graph whose stage it is, "" for one of the graph itself; tune: whether the room says it,
    and not an option, which would win.
    """

    stage: str
    keys: tuple[str, ...]
    places: tuple[Place, ...]
    value: Node
    stage_place: Place
    within: str = ""
    tune: bool = False

    @property
    def written(self) -> str:
        """The whole option."""
        return self.stage_place.written

    def below(self, subgraph: str) -> Override:
        """The override, named from within a sub-graph."""
        within = f"{self.within}/{subgraph}" if self.within else subgraph
        return replace(self, stage=self.stage.removeprefix(f"{subgraph}/"), within=within)


def as_option(name: str, value: Any) -> str:
    """NAME=VALUE, as `--set` takes it, for a value that a script gives. Raises FollowspotError."""
    try:
        return f"{name}={value if isinstance(value, str) else json.dumps(value, default=_plain)}"
    except (TypeError, ValueError) as error:
        raise FollowspotError(f"{name} cannot be {value!r}: {error}") from None


def _plain(value: Any) -> Any:
    """A value of numpy or a path in JSON's types. Raises TypeError for another one."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"it holds a {type(value).__name__}; parameters are numbers, text, lists and mappings")


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
    return Override(keys[0], tuple(keys[1:]), tuple(places[1:]), node, places[0])


def read_overrides(options: Iterable[str], mistakes: list[Mistake]) -> list[Override]:
    """Read all options of a command; note a mistake for each that is malformed or undoes another."""
    found = [change for option in options if (change := read_override(option, mistakes)) is not None]
    mistakes += _contradictions(found)
    return found


def _contradictions(overrides: Sequence[Override]) -> Iterator[Mistake]:
    """A mistake for each option that undoes an earlier one: another value of its key, or of what holds it."""
    for first, second in combinations(overrides, 2):
        name, _, before = first.written.partition("=")
        other, _, value = second.written.partition("=")
        if _undoes(second.written, first.written) and (
            _path(name) != _path(other) or before.strip() != value.strip()
        ):
            text = f'"{name:.80}" is set to {before:.80}, and'
            text = f"{text} to {value:.80}" if name == other else f'{text} "{other:.80}" to {value:.80}'
            yield Mistake(
                replace(second.stage_place, width=max(1, len(other))), text, "leave one of them out"
            )


def not_undone(options: Sequence[str], later: Sequence[str]) -> list[str]:
    """The options whose keys no later option gives another value."""
    return [option for option in options if not any(_undoes(other, option) for other in later)]


def _undoes(option: str, earlier: str) -> bool:
    """Whether an option replaces all that an earlier one sets."""
    path = _path(option)
    return len(path) > 1 and _path(earlier)[: len(path)] == path


def _path(option: str) -> tuple[str, ...]:
    """The stage and the keys that an option sets; STAGE.with.KEY is STAGE.KEY."""
    stage, *keys = option.partition("=")[0].split(".")
    return (stage, *(keys[1:] if keys[:1] == ["with"] else keys))


def is_set(node: Node) -> bool:
    """True if a value comes from `--set`, or was set while the graph ran."""
    return node.place.file in (_FILE, WHILE_IT_RAN)


def below_set(tune: Node, given: Node | None) -> Node:
    """The tuned value, in which values of `--set` keep their places."""
    if given is None or not _holds_set(given):
        return tune
    # The mapping that `--set STAGE.PARAMETER.KEY=VALUE` makes for KEY has the place of its own key.
    whole = is_set(given) and given.place != given.key
    if whole or not (isinstance(tune.value, Mapping) and isinstance(given.value, Mapping)):
        return given
    kept = {key: node for key, node in given.value.items() if _holds_set(node)}
    below = {key: below_set(tune.value[key], node) for key, node in kept.items() if key in tune.value}
    return replace(tune, value={**tune.value, **kept, **below})


def _holds_set(node: Node) -> bool:
    """True if `--set` gives the value or a part of it."""
    return is_set(node) or (isinstance(node.value, Mapping) and any(map(_holds_set, node.value.values())))


def options(node: Node) -> Iterator[str]:
    """The options that give a value or a part of it, as they are written."""
    if is_set(node):
        yield node.place.written
    for inner in node.value.values() if isinstance(node.value, Mapping) else ():
        yield from options(inner)


def overridden(entry: Node, override: Override, mistakes: list[Mistake]) -> Node:
    """The entry of a stage with an override in its place."""
    keys, places = override.keys, override.places
    if override.tune:
        given: Node | None = entry
        for key in keys:
            given = child(given, key)
        return with_value(entry, keys, places, below_set(override.value, given))
    nested = isinstance(entry.value, Mapping) and "graph" in entry.value
    if keys[0] not in (SUBGRAPH if nested else ENVELOPE):  # a parameter
        keys, places = ("with", *keys), (places[0], *places)
    elif keys[0] in _DEEP and len(keys) == 1:
        text = f'"{keys[0]}" holds several values'
        mistakes.append(Mistake(places[0], text, f"name one: {override.stage}.{keys[0]}.NAME=VALUE"))
        return entry
    return with_value(entry, keys, places, override.value)


def with_value(node: Node, keys: Sequence[str], places: Sequence[Place], value: Node) -> Node:
    """The tree with a value put under a path of keys; places: of the keys."""
    if not keys:
        return replace(value, key=node.key)
    inner = dict(node.value) if isinstance(node.value, Mapping) else {}
    old = inner.get(keys[0], Node(None, places[0], places[0]))
    inner[keys[0]] = with_value(replace(old, key=places[0]), keys[1:], places[1:], value)
    return replace(node, value=inner)
