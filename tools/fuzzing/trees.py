"""Well-formed documents that say extreme things: values, keys, names and whole subtrees are replaced.

A document is a tree of mappings, lists and scalars; a mapping is a list of pairs, so that keys can stand in
it twice, and `Raw` is a piece of YAML as it is, so that numbers, aliases and tags can be what Python has no
value for.
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import yaml

Tree = Any


@dataclass(frozen=True)
class Raw:
    """A piece of YAML."""

    text: str


@dataclass
class Pairs:
    """A mapping; keys may stand in it twice."""

    items: list[tuple[str, Tree]]

    def get(self, key: str) -> Tree:
        """The first value of a key."""
        return next((value for name, value in self.items if name == key), None)

    def put(self, key: str, value: Tree) -> None:
        """Replace the first value of a key, or add it."""
        for number, (name, _) in enumerate(self.items):
            if name == key:
                self.items[number] = (key, value)
                return
        self.items.append((key, value))


def read_tree(text: str) -> Tree:
    """The tree of a good document."""
    return _tree(yaml.safe_load(text))


def emit(tree: Tree) -> str:
    """The document, in flow style."""
    if isinstance(tree, Raw):
        return tree.text
    if isinstance(tree, Pairs):
        return "{" + ", ".join(f"{_scalar(key)}: {emit(value)}" for key, value in tree.items) + "}"
    if isinstance(tree, list):
        return "[" + ", ".join(map(emit, tree)) + "]"
    return _scalar(tree)


def mutated(tree: Tree, rng: random.Random, more: Callable[[Tree, random.Random], None]) -> Tree:
    """The tree, changed in place in one to four ways; more: one that suits the kind of document."""
    for _ in range(rng.choice((1, 1, 1, 1, 2, 4))):
        if rng.random() < 0.7:
            more(tree, rng)
        else:
            rng.choice(_WAYS)(tree, rng)
    return tree


def extreme(rng: random.Random) -> Tree:
    """A value that hardly ever fits its place."""
    return rng.choice(rng.choice(_EXTREMES))


def extreme_like(value: Tree, rng: random.Random) -> Tree:
    """An extreme of the kind of a value, so that it gets past the first check."""
    if isinstance(value, bool) or value is None:
        return extreme(rng)
    if isinstance(value, int | float):
        if rng.random() < 0.4:
            return rng.choice(_NUMBERS)
        scaled = (value or 1) * rng.choice(_FACTORS)
        return scaled if isinstance(value, float) else round(scaled)
    if isinstance(value, str):
        return rng.choice(_TEXTS)
    if isinstance(value, list) and value:
        items = list(value)
        if rng.random() < 0.3:
            return [extreme_like(item, rng) for item in items]
        place = rng.randrange(len(items))
        items[place] = extreme_like(items[place], rng)
        return items
    return extreme(rng)


_FACTORS = (-1, 0, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 2, 10, 100, 1e3, 1e4, 1e6, 1e9, 1e12)
_NUMBERS: tuple[Tree, ...] = (
    *(0, 1, -1, 2, 3, 7, 100, 255, 256, 10_000, 65_536, 1_000_000, 10**9, 2**31 - 1, 2**31, 2**32),
    *(2**53, 2**62, 2**63 - 1, 2**63, -(2**63), 2**64, 10**30, -(10**6), 10**18),
    *(0.0, -0.0, 0.5, -0.5, 1e-9, 1e-300, 5e-324, 1e9, 1e18, 1e154, 1e300, 1.7e308, -1.7e308),
    *map(Raw, ("1e400", "-1e400", ".nan", ".inf", "-.inf", "0x" + "f" * 5000, "9" * 5000, "1" + "0" * 99)),
)
_TEXTS: tuple[Tree, ...] = (
    *("", " ", "x", "x" * 300, "x" * 10_000, "é" * 200, "\0", "a\0b", "a\nb", "\x1b[2J", "\u202e", "𝔘"),
    *("../../../etc/passwd", "/etc/passwd", "/dev/zero", "/dev/full", "/proc/self/mem", "~", ".", "..", "/"),
    *("${x}", "${", "${least}", "a.b", "a.b.c", ".", "*", "**", "$x", "?", "#", "@", "a/b", "cam0", "track"),
    *("0", "1e5", "1e400", "nan", "inf", "-1", "9" * 30, "true", "null", "None", "[1, 2]", "{a: 1}"),
    *("sim.camera", "balls.kalman", "sinks.csv", "cameras.video", "cameras.device"),
    *("room.source", "sinks.osc", "recording.port[sim.camera.out]", "recording.port["),
    *("cameras", "cameras[kind=color]", "cameras[", "latest"),
)
_ODD: tuple[Tree, ...] = (
    *(None, True, False, [], [[]], [None], [1_000_000, 1_000_000], [0] * 1000, ["x"] * 100, Pairs([])),
    Pairs([("x", 1)]),
    Pairs([("from", "track"), ("delay", 1000)]),
    Pairs([("x", 1), ("x", 2)]),
    *map(Raw, ("[" * 60 + "]" * 60, "{a: " * 60 + "1" + "}" * 60, "*a", "&a [*a]", "&b 1", "!!float 1", "")),
    *map(Raw, ("2020-01-01", "12:30:00", "0o17", "1_000", "? x", "<<", "'unfinished", "\t", "- 1", "|\n x")),
    Raw("&a [x, x, x, x, x, x, x, x]"),
    Raw("[&a [1,1,1,1,1,1,1,1,1], &b [*a,*a,*a,*a,*a,*a,*a,*a], &c [*b,*b,*b,*b,*b,*b,*b,*b], [*c,*c,*c]]"),
)
_EXTREMES = (_NUMBERS, _TEXTS, _ODD)


def _tree(value: Any) -> Tree:
    if isinstance(value, dict):
        return Pairs([(str(key), _tree(inner)) for key, inner in value.items()])
    return [_tree(inner) for inner in value] if isinstance(value, list) else value


def _scalar(value: Any) -> str:
    if isinstance(value, float):
        return (
            repr(value) if math.isfinite(value) else str(value).replace("inf", ".inf").replace("nan", ".nan")
        )
    return json.dumps(value)


def _places(tree: Tree) -> Iterator[tuple[Pairs | list[Tree], int]]:
    """Every value below a tree with its container and its key."""
    if isinstance(tree, Pairs):
        inner = [value for _, value in tree.items]
    elif isinstance(tree, list):
        inner = tree
    else:
        return
    for number, value in enumerate(inner):
        yield tree, number
        yield from _places(value)


def _place(tree: Tree, rng: random.Random) -> tuple[Pairs | list[Tree], int]:
    return rng.choice(list(_places(tree)) or [([tree], 0)])


def _at(holder: Pairs | list[Tree], number: int) -> Tree:
    return holder.items[number][1] if isinstance(holder, Pairs) else holder[number]


def _set(holder: Pairs | list[Tree], number: int, value: Tree) -> None:
    if isinstance(holder, Pairs):
        holder.items[number] = (holder.items[number][0], value)
    else:
        holder[number] = value


def _replace(tree: Tree, rng: random.Random) -> None:
    holder, number = _place(tree, rng)
    _set(holder, number, extreme(rng))


def _replace_alike(tree: Tree, rng: random.Random) -> None:
    holder, number = _place(tree, rng)
    _set(holder, number, extreme_like(_at(holder, number), rng))


def _drop(tree: Tree, rng: random.Random) -> None:
    holder, number = _place(tree, rng)
    del (holder.items if isinstance(holder, Pairs) else holder)[number]


def _double(tree: Tree, rng: random.Random) -> None:
    holder, number = _place(tree, rng)
    items: list[Any] = holder.items if isinstance(holder, Pairs) else holder
    items.insert(rng.randrange(len(items) + 1), items[number])


def _rename(tree: Tree, rng: random.Random) -> None:
    holder, number = _place(tree, rng)
    if isinstance(holder, Pairs):
        name = rng.choice(_TEXTS)
        holder.items[number] = (name if isinstance(name, str) else "x", holder.items[number][1])


def _move(tree: Tree, rng: random.Random) -> None:
    """A value takes the place of another, which may hold it."""
    value = _at(*_place(tree, rng))
    _set(*_place(tree, rng), read_tree(emit_plain(value)))


def emit_plain(tree: Tree) -> str:
    """The document without pieces that are no YAML by themselves."""
    return emit(_plain(tree))


def _plain(tree: Tree) -> Tree:
    if isinstance(tree, Pairs):
        return Pairs([(key, _plain(value)) for key, value in tree.items])
    if isinstance(tree, list):
        return [_plain(value) for value in tree]
    return None if isinstance(tree, Raw) or (isinstance(tree, str) and not tree.isprintable()) else tree


_WAYS = (_replace, _replace, _replace_alike, _replace_alike, _replace_alike, _drop, _double, _rename, _move)
