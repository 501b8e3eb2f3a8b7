"""The tree of a YAML document: nodes with their places; from and to plain Python values.

`followspot.yaml.reader` makes the tree of a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from followspot.errors import InputError, Mistake, Place
from followspot.yaml.scalars import STR_TAG, Scalar, fits, resolve

MAX_DEPTH = 50
"""Most levels of nested values."""
MAX_NODES = 100_000
"""Most nodes after aliases are expanded, so that a short file cannot become a huge tree."""


@dataclass(frozen=True)
class Node:
    """A scalar, a sequence or a mapping whose keys are text, with its place.

    key: place of its key, or the node's own place if it has none;
    nodes, depth: size of the tree below, itself included; a long text counts as several nodes.
    """

    value: Scalar | tuple[Node, ...] | Mapping[str, Node]
    place: Place
    key: Place
    nodes: int = 1
    depth: int = 1


def plain(node: Node) -> Any:
    """The node as plain Python values: dict, list, str, int, float, bool, None."""
    if isinstance(node.value, Mapping):
        return {key: plain(inner) for key, inner in node.value.items()}
    if isinstance(node.value, tuple):
        return [plain(inner) for inner in node.value]
    return node.value


def child(node: Node | None, key: str) -> Node | None:
    """The value of a key; None if the node is no mapping or has no such key."""
    return node.value.get(key) if node is not None and isinstance(node.value, Mapping) else None


def node_of(value: Any, place: Place) -> Node:
    """The inverse of `plain`: a tree whose nodes share one place. Raises InputError at a limit."""
    return _node_of(value, place, MAX_DEPTH)


def dump(data: Any) -> str:
    """The text of a document from plain Python values; `reader.parse` gives the same values back."""
    return str(
        yaml.dump(
            data, Dumper=_Dumper, sort_keys=False, width=110, default_flow_style=None, allow_unicode=True
        )
    )


_LINE_ENDS = frozenset("\x85\u2028\u2029")
"""Characters that end a line for YAML unless they are escaped, as double quotes do."""


class _Dumper(yaml.SafeDumper):
    """Quotes text that YAML 1.2 reads as another value; PyYAML by itself quotes by the rules of YAML 1.1."""

    def text(self, value: str) -> yaml.ScalarNode:
        """A text, quoted if it would be read as something else."""
        if not _LINE_ENDS.isdisjoint(value):
            return self.represent_scalar(STR_TAG, value, style='"')
        try:
            plain_text = resolve(value) == value
        except ValueError:
            plain_text = False
        return self.represent_scalar(STR_TAG, value, style=None if plain_text else "'")


_Dumper.add_representer(str, _Dumper.text)


def _mistake(place: Place, text: str, remedy: str) -> InputError:
    return InputError([Mistake(place, text, remedy)])


def _node_of(value: Any, place: Place, depth: int) -> Node:
    """See `node_of`; depth: levels that are left."""
    if depth == 0:
        raise _mistake(place, f"values are nested more than {MAX_DEPTH} deep", "flatten them")
    if isinstance(value, Mapping):
        entries = {str(key): _node_of(inner, place, depth - 1) for key, inner in value.items()}
        return Node(entries, place, place)
    if isinstance(value, list | tuple):
        return Node(tuple(_node_of(inner, place, depth - 1) for inner in value), place, place)
    if isinstance(value, int) and not fits(value):
        raise _mistake(place, "this whole number does not fit into 64 bits", "shorten it")
    if value is None or isinstance(value, str | int | float):
        return Node(value, place, place)
    raise _mistake(
        place, f"a {type(value).__name__} is not a YAML value", "use numbers, text, lists and mappings"
    )
