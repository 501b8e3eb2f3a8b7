"""`${name}` in a graph file: replaced by the value under `vars`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from followspot.document import MAX_NODES, MAX_TEXT, Node, Scalar
from followspot.errors import Mistake, did_you_mean

_REFERENCE = re.compile(r"\$\{([^{}]*)\}")


class Variables:
    """The variables of a graph. They add limited amounts to it: a short text could name a long one often."""

    def __init__(self, values: Mapping[str, Node], mistakes: list[Mistake]) -> None:
        """mistakes: list that receives mistakes."""
        self.values = values
        self.mistakes = mistakes
        self.added = 0

    def substituted(self, node: Node) -> Node:
        """The tree with every reference replaced; a value that is one reference takes the variable's type."""
        value = node.value
        if isinstance(value, Mapping):
            return replace(node, value={key: self.substituted(child) for key, child in value.items()})
        if isinstance(value, tuple):
            return replace(node, value=tuple(self.substituted(child) for child in value))
        if not isinstance(value, str) or "${" not in value or self.added > MAX_NODES:
            return node
        if value.count("${") != len(_REFERENCE.findall(value)):
            self._fail(node, "there is a ${ without its }", "write ${NAME}")
            return node
        whole = _REFERENCE.fullmatch(value)
        return replace(
            node, value=self._value(whole[1], node) if whole is not None else self._joined(node, value)
        )

    def _value(self, name: str, node: Node) -> Scalar | tuple[Node, ...] | Mapping[str, Node]:
        """The value of a variable; nothing if it would make the graph too large."""
        found = self._lookup(name, node)
        return found.value if self._afford(found.nodes, node) else None

    def _joined(self, node: Node, value: str) -> str:
        """A text with the texts of variables in it; without them if it would be too long."""
        parts = _REFERENCE.split(value)  # text, name, text, name, ..., text
        if not self._afford(len(parts), node):
            return ""
        parts[1::2] = [self._text(name, node) for name in parts[1::2]]
        if sum(map(len, parts)) <= MAX_TEXT:
            return "".join(parts)
        self._fail(node, f"with its variables this text has more than {MAX_TEXT} characters", "shorten it")
        return ""

    def _text(self, name: str, node: Node) -> str:
        found = self._lookup(name, node).value
        if isinstance(found, tuple | Mapping):
            self._fail(node, f'variable "{name}" is no text', f"use ${{{name}}} as a whole value")
            return ""
        return str(found)

    def _afford(self, nodes: int, node: Node) -> bool:
        """True if the graph may grow by so much; the first excess is noted as a mistake."""
        self.added += nodes
        if self.added > MAX_NODES:
            self._fail(node, f"variables add more than {MAX_NODES} values to the graph", "use fewer")
        return self.added <= MAX_NODES

    def _lookup(self, name: str, node: Node) -> Node:
        """The variable's node; an unknown one is noted, and the text stays as it is."""
        found = self.values.get(name.strip())
        if found is not None:
            return found
        remedy = did_you_mean(name.strip(), self.values, "vars")
        self.mistakes.append(Mistake(node.place, f'there is no variable "{name.strip()}"', remedy))
        return node

    def _fail(self, node: Node, text: str, remedy: str) -> None:
        self.mistakes.append(Mistake(node.place, text, remedy))
