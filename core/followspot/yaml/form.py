"""Reader of a mapping that a user wrote: key by key, collecting every mistake with its place."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from followspot.errors import Guess, Mistake, did_you_mean
from followspot.messages import Array
from followspot.valid_values.names import HOST_NAME, is_title
from followspot.yaml.node import Node, plain

Shape = tuple[int, ...]
MAX_QUOTED = 80
"""Characters of a text that a mistake quotes."""


class Form:
    """Reads one mapping. Each method returns None and notes a mistake if the value is missing or wrong.

    noun: describes the mapping in messages, as in "camera cam0"; keys: all keys that it may hold.
    """

    def __init__(self, node: Node, noun: str, keys: Sequence[str], mistakes: list[Mistake]) -> None:
        self.node = node
        self.noun = noun
        self.mistakes = mistakes
        self.entries: Mapping[str, Node] = {}
        if isinstance(node.value, Mapping):
            self.entries = node.value
        else:
            self.wrong(
                node, f"{noun} is a mapping of keys to values, not {kind_of(node)}", f"keys: {_list(keys)}"
            )
        for key, entry in self.entries.items():
            if key not in keys:
                self.unknown(entry, f'{noun} has no key "{key}"', key, keys, "keys")

    def wrong(self, node: Node, text: str, remedy: str | Guess = "") -> None:
        """Note a mistake at a value."""
        self.mistakes.append(Mistake(node.place, text, remedy))

    def unfit(self, key: str, text: str, remedy: str) -> None:
        """Note a mistake at a key that is there."""
        self.mistakes.append(Mistake(self.entries[key].key, text, remedy))

    def unknown(self, node: Node, text: str, word: str, known: Collection[str], noun: str) -> None:
        """Note a mistake at the key of a value: an unknown word."""
        self.mistakes.append(Mistake(node.key, text, did_you_mean(word, known, noun)))

    def get(self, key: str, *, required: bool = False) -> Node | None:
        """The value of a key; a missing required one is a mistake at the key of the mapping."""
        found = self.entries.get(key)
        if found is None and required and isinstance(self.node.value, Mapping):
            self.mistakes.append(Mistake(self.node.key, f'{self.noun} lacks "{key}"', f"add {key}: ..."))
        return found

    def text(self, key: str, *, required: bool = False, choices: Sequence[str] = ()) -> str | None:
        """A text; one of the choices, if any are given."""
        node = self.get(key, required=required)
        if node is None:
            return None
        if not isinstance(node.value, str) or not node.value:
            self.wrong(
                node, f"{key} is text, not {kind_of(node)}", "quote a text that looks like something else"
            )
            return None
        if choices and node.value not in choices:
            self.wrong(node, f'{key} cannot be "{node.value}"', did_you_mean(node.value, choices, "one of"))
            return None
        return node.value

    def title(self, key: str) -> str | None:
        """The name of a graph or a room."""
        found = self.text(key)
        if found is None or is_title(found):
            return found
        self.wrong(
            self.entries[key], f"{key} cannot be {kind_of(self.entries[key])}", "a short name without /"
        )
        return None

    def host(self, key: str = "host") -> str:
        """The name of a host, empty if it is missing."""
        found = self.text(key)
        if found is None or HOST_NAME.fullmatch(found):
            return found or ""
        remedy = "letters, digits, _, . and -, up to 64 characters"
        self.wrong(self.entries[key], f"{key} cannot be {kind_of(self.entries[key])}", remedy)
        return ""

    def number(
        self,
        key: str,
        *,
        least: float = -math.inf,
        most: float = math.inf,
        above: float = -math.inf,
        required: bool = False,
    ) -> float | None:
        """A finite number, from `least` to `most` and greater than `above`."""
        node = self.get(key, required=required)
        if node is None:
            return None
        if _is_finite(node):
            value = float(node.value)  # type: ignore[arg-type]  # it is a number
            if least <= value <= most and value > above:
                return value
        wanted = f"greater than {above:g}" if math.isfinite(above) else f"not below {least:g}"
        if math.isfinite(most):
            wanted = f"{wanted}, at most {most:g}" if math.isfinite(above) else f"from {least:g} to {most:g}"
        self.wrong(node, f"{key} cannot be {kind_of(node)}", f"write a number {wanted}")
        return None

    def whole(self, key: str, *, least: int, most: int) -> int | None:
        """A whole number from `least` to `most`."""
        node = self.get(key)
        if node is None:
            return None
        value = node.value
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            self.wrong(
                node, f"{key} cannot be {kind_of(node)}", f"write a whole number from {least} to {most}"
            )
            return None
        return value

    def switch(self, key: str) -> bool:
        """True or false; false if it is missing."""
        node = self.get(key)
        if node is None or isinstance(node.value, bool):
            return node is not None and bool(node.value)
        self.wrong(node, f"{key} cannot be {kind_of(node)}", "write true or false")
        return False

    def array(
        self, key: str, shapes: Sequence[Shape], *, most: float = math.inf, required: bool = False
    ) -> Array | None:
        """Finite numbers in one of the shapes, as float64; most: the largest absolute value."""
        node = self.get(key, required=required)
        return None if node is None else self.numbers(node, key, shapes, most=most)

    def numbers(
        self, node: Node, what: str, shapes: Sequence[Shape], *, most: float = math.inf
    ) -> Array | None:
        """A node of finite numbers in one of the shapes, as float64; most: the largest absolute value."""
        wanted = " or ".join(" x ".join(map(str, shape)) for shape in shapes)
        if not isinstance(node.value, tuple):
            self.wrong(node, f"{what} is a list of {wanted} numbers, not {kind_of(node)}")
            return None
        bad = next((leaf for leaf in _leaves(node) if not _is_finite(leaf)), None)
        if bad is not None:
            self.wrong(bad, f"{what} holds {kind_of(bad)} where a finite number belongs")
            return None
        shape = _shape(node)
        if shape not in shapes:
            have = "rows of different length" if shape is None else " x ".join(map(str, shape))
            self.wrong(node, f"{what} has {wanted} numbers, not {have}")
            return None
        found = np.array(plain(node), dtype=np.float64)
        if found.size and np.abs(found).max() > most:
            self.wrong(node, f"{what} holds a number beyond {most:g}", "check the unit")
            return None
        return found

    def values(self, key: str) -> dict[str, Any]:
        """The plain values of a mapping, empty if it is missing; numbers must be finite."""
        entries = self.mapping(key)
        for node in entries.values():
            for leaf in _within(node):
                if isinstance(leaf.value, float) and not math.isfinite(leaf.value):
                    self.wrong(leaf, f"{key} holds {leaf.value}", "write a finite number")
        return {name: plain(node) for name, node in entries.items()}

    def mapping(self, key: str) -> Mapping[str, Node]:
        """A mapping of names to values, empty if it is missing."""
        node = self.get(key)
        if node is None or node.value is None:
            return {}
        if not isinstance(node.value, Mapping):
            self.wrong(
                node, f"{key} is a mapping of names to values, not {kind_of(node)}", f"{key}: {{NAME: VALUE}}"
            )
            return {}
        return node.value


def kind_of(node: Node) -> str:
    """The kind of a node, in words."""
    if isinstance(node.value, Mapping):
        return "a mapping"
    if isinstance(node.value, tuple):
        return "a list" if node.value else "an empty list"
    if node.value is None:
        return "nothing"
    if isinstance(node.value, bool):
        return str(node.value).lower()
    if not isinstance(node.value, str):
        return f"{node.value}"
    return f'"{node.value}"' if len(node.value) <= MAX_QUOTED else f'"{node.value[:MAX_QUOTED]}..."'


def _leaves(node: Node) -> Iterator[Node]:
    """The nodes within nested lists that are no lists themselves."""
    if not isinstance(node.value, tuple):
        yield node
        return
    for item in node.value:
        yield from _leaves(item)


def _within(node: Node) -> Iterator[Node]:
    """The scalars within nested lists and mappings."""
    for leaf in _leaves(node):
        if isinstance(leaf.value, Mapping):
            for inner in leaf.value.values():
                yield from _within(inner)
        else:
            yield leaf


def _shape(node: Node) -> Shape | None:
    """Sizes of nested lists; None if they are ragged."""
    if not isinstance(node.value, tuple):
        return ()
    inner = {_shape(item) for item in node.value}
    if len(inner) > 1 or None in inner:
        return None
    return (len(node.value), *(inner.pop() or () if inner else ()))


def _is_finite(node: Node) -> bool:
    value = node.value
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer too large for a float
        return False


def _list(words: Sequence[str]) -> str:
    return ", ".join(words)
