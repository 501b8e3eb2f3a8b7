"""The tree of a YAML document, built from the events of PyYAML's C parser.

Limits on bytes, depth, nodes and scalars protect against untrusted files.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import yaml

from followspot.errors import Mistake, Place
from followspot.yaml.node import MAX_DEPTH, MAX_NODES, Node
from followspot.yaml.scalars import STR_TAG, Scalar, resolve

MAX_TEXT = 4096
"""Longest scalar, characters; the longest path has as many."""
_TEXT_OF_A_NODE = 100
"""Characters of a text that count as one node."""
_MAX_MISTAKES = 1000
"""Mistakes after which the parser does not read the rest."""


class DocumentTooLarge(Exception):
    """The document exceeds a limit; the parser does not read the rest."""


@dataclass
class _Open:
    """A sequence or mapping that the parser has not finished."""

    place: Place
    anchor: str | None
    items: list[Node]
    mapping: bool


class TreeBuilder:
    """Builds the tree from parser events, without recursion, so that depth cannot exhaust the stack."""

    def __init__(self, file: str, written: str) -> None:
        self.file = file
        self.written = written
        self.mistakes: list[Mistake] = []
        self.root: Node | None = None
        self.open: list[_Open] = []
        self.anchors: dict[str, Node] = {}
        self.total = 0

    def fail(self, place: Place, text: str, remedy: str) -> None:
        """Note a mistake; raises DocumentTooLarge after too many."""
        self.mistakes.append(Mistake(place, text, remedy))
        if len(self.mistakes) >= _MAX_MISTAKES:
            raise DocumentTooLarge

    def take(self, event: Any) -> None:
        """Take the next event of the parser."""
        if isinstance(event, yaml.ScalarEvent):
            self._add(self._scalar(event), event.anchor)
        elif isinstance(event, yaml.AliasEvent):
            self._alias(event)
        elif isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
            self._start(event)
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            self._end()
        elif isinstance(event, yaml.DocumentStartEvent) and self.root is not None:
            self.fail(self._place(event), "a second document begins here", "one file holds one document")
            raise DocumentTooLarge

    def _place(self, event: Any) -> Place:
        start, end = event.start_mark, event.end_mark
        width = end.column - start.column if end.line == start.line else 1
        return Place(self.file, start.line + 1, start.column + 1, max(1, width), self.written)

    def _scalar(self, event: yaml.ScalarEvent) -> Node:
        """A scalar with the value that YAML 1.2 gives it; notes tags and values that are not allowed."""
        place = self._place(event)
        value: Scalar = event.value
        if event.tag not in (None, "!", STR_TAG):
            self.fail(place, f"the tag {event.tag} is not used here", "remove it, or quote the text")
        elif event.implicit[0] and event.tag is None:
            try:
                value = resolve(event.value)
            except ValueError as error:
                self.fail(place, str(error), "shorten it, or quote it as text")
                value = None
        if isinstance(value, str) and len(value) > MAX_TEXT:
            self.fail(place, f"this text has more than {MAX_TEXT} characters", "shorten it")
            value = None
        size = len(value) // _TEXT_OF_A_NODE if isinstance(value, str) else 0
        return Node(value, place, place, 1 + size)

    def _alias(self, event: yaml.AliasEvent) -> None:
        place = self._place(event)
        found = self.anchors.get(str(event.anchor))
        if found is None:
            self.fail(place, f'no anchor "&{event.anchor}" stands before this alias', "define it above")
            found = Node(None, place, place)
        self._add(replace(found, key=place), None)

    def _start(self, event: yaml.MappingStartEvent | yaml.SequenceStartEvent) -> None:
        place = replace(self._place(event), width=1)
        if event.tag not in (None, "!"):
            self.fail(place, f"the tag {event.tag} is not used here", "remove it")
        if len(self.open) >= MAX_DEPTH:
            self._too_deep(place)
        self.open.append(_Open(place, event.anchor, [], isinstance(event, yaml.MappingStartEvent)))

    def _end(self) -> None:
        done = self.open.pop()
        value: tuple[Node, ...] | Mapping[str, Node]
        value = self._mapping(done.items) if done.mapping else tuple(done.items)
        inner = tuple(value.values()) if isinstance(value, dict) else tuple(done.items)
        nodes = 1 + sum(node.nodes for node in inner)
        depth = 1 + max((node.depth for node in inner), default=0)
        self._add(Node(value, done.place, done.place, nodes, depth), done.anchor)

    def _mapping(self, items: list[Node]) -> dict[str, Node]:
        """A mapping of keys and values in turn, with what `<<` merges; notes keys that stand twice."""
        own: dict[str, Node] = {}
        merged: dict[str, Node] = {}
        for key, node in zip(items[::2], items[1::2], strict=True):
            name = self._key(key)
            if name is None:
                continue
            if name == "<<":
                for part in node.value if isinstance(node.value, tuple) else (node,):
                    for inner, value in self._merge(part, key.place).items():
                        merged.setdefault(inner, value)
            elif name in own:
                first = own[name].key
                self.fail(
                    key.place, f'the key "{name}" stands here twice', f"first in line {first.line}; keep one"
                )
            else:
                own[name] = replace(node, key=key.place)
        return {**own, **{name: node for name, node in merged.items() if name not in own}}

    def _key(self, key: Node) -> str | None:
        if isinstance(key.value, tuple | Mapping):
            self.fail(
                key.place, "a key must be text", "write NAME: VALUE; quote a text that starts with [ or {"
            )
            return None
        return key.value if isinstance(key.value, str) else str(key.value)

    def _merge(self, part: Node, place: Place) -> Mapping[str, Node]:
        if isinstance(part.value, Mapping):
            return part.value
        self.fail(place, '"<<" merges mappings only', "write <<: *anchor of a mapping")
        return {}

    def _add(self, node: Node, anchor: str | None) -> None:
        """Add a finished node to the sequence or mapping that is open. Raises DocumentTooLarge at a limit."""
        if len(self.open) + node.depth > MAX_DEPTH:
            self._too_deep(node.key)
        aliased = node.key != node.place
        self.total += node.nodes if aliased or not isinstance(node.value, tuple | Mapping) else 1
        if self.total > MAX_NODES:
            self.fail(node.key, f"the file has more than {MAX_NODES} values", "split the file")
            raise DocumentTooLarge
        if anchor:
            self.anchors[anchor] = node
        if self.open:
            self.open[-1].items.append(node)
        else:
            self.root = node

    def _too_deep(self, place: Place) -> None:
        self.fail(place, f"values are nested more than {MAX_DEPTH} deep", "flatten the file")
        raise DocumentTooLarge
