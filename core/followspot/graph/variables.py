"""`${name}` in a graph file: replaced by what stands under `vars`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from followspot.document import Node
from followspot.errors import Mistake, did_you_mean

_REFERENCE = re.compile(r"\$\{([^}]*)\}")


def substitute(node: Node, values: Mapping[str, Node], mistakes: list[Mistake]) -> Node:
    """The tree with every reference replaced; a value that is one reference takes the variable's type."""
    value = node.value
    if isinstance(value, Mapping):
        return replace(node, value={key: substitute(child, values, mistakes) for key, child in value.items()})
    if isinstance(value, tuple):
        return replace(node, value=tuple(substitute(child, values, mistakes) for child in value))
    if not isinstance(value, str) or "${" not in value:
        return node
    if value.count("${") != len(_REFERENCE.findall(value)):
        mistakes.append(Mistake(node.place, "there is a ${ without its }", "write ${NAME}"))
        return node
    whole = _REFERENCE.fullmatch(value)
    if whole is not None:
        found = _lookup(whole[1], node, values, mistakes)
        return replace(node, value=found.value)
    return replace(node, value=_REFERENCE.sub(lambda part: _text(part[1], node, values, mistakes), value))


def _text(name: str, node: Node, values: Mapping[str, Node], mistakes: list[Mistake]) -> str:
    found = _lookup(name, node, values, mistakes).value
    if isinstance(found, tuple | Mapping):
        mistakes.append(
            Mistake(node.place, f'variable "{name}" is no text', f"use ${{{name}}} as a whole value")
        )
        return ""
    return str(found)


def _lookup(name: str, node: Node, values: Mapping[str, Node], mistakes: list[Mistake]) -> Node:
    """The variable's node; an unknown one is noted, and the text stays as it is."""
    found = values.get(name.strip())
    if found is None:
        remedy = did_you_mean(name.strip(), values, "vars")
        mistakes.append(Mistake(node.place, f'there is no variable "{name.strip()}"', remedy))
        return node
    return found
