"""`cameras:` and `each:` of a sub-graph, carried over to the stages inside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from followspot.errors import Mistake
from followspot.graph.selector import Selector, intersection, read_selector, within
from followspot.room import Member
from followspot.yaml.node import Node

Limit = Selector | Member
"""A limit of a sub-graph: the cameras that it serves, or the member of a set or tag."""


def narrowed(each: Node, limits: Sequence[Limit]) -> Node:
    """The value of `each` within these limits; one that cannot be read stays, for a later step to note."""
    selector = read_selector(each, [])
    if not selector.readable or not limits:
        return each
    for limit in limits:
        if isinstance(limit, Member):
            selector = within(selector, limit)
        elif limit.set == selector.set:
            selector = intersection(selector, limit)
    return replace(each, value=selector.text)


def both(first: Node, second: Node) -> Node:
    """The selector of the members that two selectors choose, at the place of the first.

    The first alone if one cannot be read, or if they choose of different sets.
    """
    one, other = read_selector(first, []), read_selector(second, [])
    if not (one.readable and other.readable and one.set == other.set):
        return first
    return replace(first, value=intersection(one, other).text)


def read_cameras(node: Node, mistakes: list[Mistake]) -> Selector | None:
    """The value of `cameras`; None if a mistake was noted."""
    selector = read_selector(node, mistakes, "cameras")
    if selector.readable and selector.set != "cameras":
        text = f'cameras cannot be "{node.value}"'
        mistakes.append(Mistake(node.place, text, 'write for example "cameras[zone=hall]"'))
    return selector if selector.set == "cameras" else None
