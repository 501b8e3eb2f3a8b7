"""Plain data with values changed, dropped, doubled and renamed: requests, heads of messages, documents.

A document may hold `Raw` pieces of YAML: numbers, aliases and tags that Python has no value for.
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fuzzing.mutation import NASTY_FLOATS, NASTY_INTEGERS, NASTY_TEXT

Tree = Any


@dataclass(frozen=True)
class Raw:
    """A piece of YAML."""

    text: str


def nasty(_: Tree, rng: random.Random) -> Tree:
    """A value that JSON and msgpack can hold."""
    return rng.choice(_NASTY)(rng)


def unlikely(value: Tree, rng: random.Random) -> Tree:
    """A value for documents: an extreme one, more often of the kind of the old one."""
    return extreme_like(value, rng) if rng.random() < 0.6 else extreme(rng)


def broken_tree(tree: Tree, rng: random.Random, other: Callable[[Tree, random.Random], Tree] = nasty) -> Tree:
    """The tree with one to three of its values changed, dropped, doubled or renamed, at random depths.

    other: gives the value that takes the place of an old one.
    """
    for _ in range(rng.choice((1, 1, 2, 3))):
        tree = _changed(tree, rng, other)
    return tree


def _changed(tree: Tree, rng: random.Random, other: Callable[[Tree, random.Random], Tree]) -> Tree:
    if isinstance(tree, dict) and tree and rng.random() < 0.93:
        key = rng.choice(list(tree))
        way = rng.randrange(8)
        if way == 0:
            return {name: value for name, value in tree.items() if name != key}
        if way == 1:
            return {**tree, rng.choice(NASTY_TEXT): tree[key]}
        return {**tree, key: _changed(tree[key], rng, other)}
    if isinstance(tree, list | tuple) and tree and rng.random() < 0.93:
        place = rng.randrange(len(tree))
        items = list(tree)
        way = rng.randrange(8)
        if way == 0:
            del items[place]
        elif way == 1:
            items.insert(place, items[place])
        else:
            items[place] = _changed(items[place], rng, other)
        return items
    return other(tree, rng)


def emit(tree: Tree) -> str:
    """The document, in flow style."""
    if isinstance(tree, Raw):
        return tree.text
    if isinstance(tree, dict):
        return "{" + ", ".join(f"{json.dumps(key)}: {emit(value)}" for key, value in tree.items()) + "}"
    if isinstance(tree, list):
        return "[" + ", ".join(map(emit, tree)) + "]"
    if isinstance(tree, float) and not math.isfinite(tree):
        return str(tree).replace("inf", ".inf").replace("nan", ".nan")
    return json.dumps(tree)


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
    *(
        "cameras",
        "cameras[kind=color]",
        "cameras[",
        "latest",
        "sensors",
        "targets",
        "zones",
        "zone[name=a|b]",
    ),
)
_ODD: tuple[Tree, ...] = (
    *(None, True, False, [], [[]], [None], [1_000_000, 1_000_000], [0] * 1000, ["x"] * 100, {}),
    *({"x": 1}, {"from": "track", "delay": 1000}, Raw("{x: 1, x: 2}")),
    *map(Raw, ("[" * 60 + "]" * 60, "{a: " * 60 + "1" + "}" * 60, "*a", "&a [*a]", "&b 1", "!!float 1", "")),
    *map(Raw, ("2020-01-01", "12:30:00", "0o17", "1_000", "? x", "<<", "'unfinished", "\t", "- 1", "|\n x")),
    Raw("&a [x, x, x, x, x, x, x, x]"),
    Raw("[&a [1,1,1,1,1,1,1,1,1], &b [*a,*a,*a,*a,*a,*a,*a,*a], &c [*b,*b,*b,*b,*b,*b,*b,*b], [*c,*c,*c]]"),
)
_EXTREMES = (_NUMBERS, _TEXTS, _ODD)


def _deep(rng: random.Random) -> Any:
    tree: Any = []
    for _ in range(rng.choice((5, 50, 500))):
        tree = [tree]
    return tree


_NASTY: tuple[Callable[[random.Random], Any], ...] = (
    lambda rng: rng.choice(NASTY_INTEGERS[:-2]),
    lambda rng: rng.choice(NASTY_FLOATS),
    lambda rng: rng.choice(NASTY_TEXT[:-4]),
    lambda rng: None,
    lambda rng: rng.random() < 0.5,
    lambda rng: [],
    lambda rng: {},
    lambda rng: [0] * rng.choice((1, 1000)),
    lambda rng: rng.randrange(-5, 50),
    _deep,
)
