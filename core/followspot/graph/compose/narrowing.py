"""`cameras:` and `each:` of a sub-graph, carried over to the stages inside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from followspot.document import Node
from followspot.errors import Mistake
from followspot.graph.selector import Selector, intersection, read_selector, within
from followspot.room import Member, Room

Limit = Selector | Member
"""What a sub-graph serves: certain cameras, or all that belongs to one member of a set or tag."""


def narrowed(each: Node, limits: Sequence[Limit]) -> Node:
    """The value of `each` within these limits; one that cannot be read stays, for a later step to note."""
    wrong: list[Mistake] = []
    selector = read_selector(each, wrong)
    if wrong or not limits:
        return each
    for limit in limits:
        if isinstance(limit, Member):
            selector = within(selector, limit)
        elif limit.set == selector.set:
            selector = intersection(selector, limit)
    return replace(each, value=selector.text)


def read_cameras(node: Node, mistakes: list[Mistake]) -> Selector | None:
    """The value of `cameras`; None if a mistake was noted."""
    before = len(mistakes)
    selector = read_selector(node, mistakes, "cameras")
    if len(mistakes) == before and selector.set != "cameras":
        text = f'cameras cannot be "{node.value}"'
        mistakes.append(Mistake(node.place, text, 'write for example "cameras[zone=hall]"'))
    return selector if len(mistakes) == before else None


def members(node: Node, name: str, room: Room | None, mistakes: list[Mistake]) -> Sequence[Member]:
    """The members that a sub-graph fans out over; none if a mistake was noted, or the room has some.

    room: None if it has mistakes itself.
    """
    before = len(mistakes)
    selector = read_selector(node, mistakes)
    if room is None or len(mistakes) > before:
        return ()
    found = selector.select(room)
    if not found:
        unknown = selector.unknown(room)
        text = f'sub-graph "{name}" fans out over {selector.text}, and the room "{room.name}" has none'
        mistakes.append(unknown or Mistake(node.place, text, "name a set or a tag that the room has"))
    return found
