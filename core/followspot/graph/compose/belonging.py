"""The members and cameras to which the stages of a sub-graph belong: those of its fan-out and `cameras`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from followspot.graph.compose.feeds import items, option, sender, with_option
from followspot.graph.compose.narrowing import Limit, both, narrowed
from followspot.graph.compose.unit import Unit
from followspot.graph.names import below
from followspot.graph.selector import Condition, Selector, read_selector
from followspot.room import Member
from followspot.yaml.node import Node, child


def belonging(entry: Mapping[str, Node], node: Node, limits: Sequence[Limit]) -> dict[str, Node]:
    """The entry of a stage with the members of the sub-graphs around it, its own fan-out aside, and the
    cameras that they are given.

    node: that the entry is the value of.
    """
    members = [
        limit for limit in limits if isinstance(limit, Member) and limit.set != _set(entry.get("each"))
    ]
    serves = [Selector(member.set, (Condition("name", (member.name,)),), node.key) for member in members]
    sees = [limit for limit in limits if isinstance(limit, Selector)]
    return _with(_with(entry, "serves", serves, node), "sees", sees, node)


def _with(entry: Mapping[str, Node], key: str, selectors: Sequence[Selector], node: Node) -> dict[str, Node]:
    """The entry with these selectors behind the written ones at the key."""
    texts = dict.fromkeys(selector.text for selector in selectors)
    if not texts:
        return dict(entry)
    written = items(entry[key]) if key in entry else ()
    found = (*written, *(Node(text, node.key, node.key) for text in texts))
    return {**entry, key: found[0] if len(found) == 1 else Node(found, node.key, node.key)}


def seen_only(stages: Mapping[str, Node], units: Iterable[Unit]) -> dict[str, Node]:
    """The stages of a flat graph; those in a sub-graph get messages of its cameras alone.

    Of an input that takes the place of a stage, its feeds say so already.
    """
    found = dict(stages)
    for unit in units:
        limits = [limit for limit in unit.limits if isinstance(limit, Selector)]
        for stage, port in unit.wired if limits else ():
            name = below(unit.name, stage)
            inputs = child(found.get(name), "in")
            feeds = child(inputs, port)
            if feeds is not None and inputs is not None and isinstance(inputs.value, Mapping):
                fed = [_of_cameras(feed, stages, limits) for feed in items(feeds)]
                value = replace(feeds, value=tuple(fed)) if isinstance(feeds.value, tuple) else fed[0]
                entry = {**_entry(found[name]), "in": replace(inputs, value={**inputs.value, port: value})}
                found[name] = replace(found[name], value=entry)
    return found


def _of_cameras(feed: Node, stages: Mapping[str, Node], limits: Sequence[Selector]) -> Node:
    """The feed from the cameras within these limits, if its sender fans out over cameras."""
    named = sender(feed)
    each = child(stages.get(named[0]), "each") if named is not None else None
    if each is None or _set(each) != "cameras":
        return feed
    selector, chosen = narrowed(each, limits), option(feed, "only")
    return with_option(feed, "only", selector if chosen is None else both(chosen, selector))


def _set(each: Node | None) -> str:
    """The set that a stage fans out over; "" if it does not."""
    return "" if each is None else read_selector(each, []).set


def _entry(node: Node) -> Mapping[str, Node]:
    return node.value if isinstance(node.value, Mapping) else {}
