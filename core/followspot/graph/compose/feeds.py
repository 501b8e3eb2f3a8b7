"""Inputs in the form of a graph file: STAGE, STAGE.PORT, {from: ..., delay: ...}, or a list of these."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from followspot.graph.compose.narrowing import both
from followspot.graph.names import SENDER
from followspot.yaml.node import Node


def items(feeds: Node) -> tuple[Node, ...]:
    """The single feeds of an input."""
    return feeds.value if isinstance(feeds.value, tuple) else (feeds,)


def origin(feed: Node) -> Node:
    """The text that names the sender; the feed itself if it has none."""
    if isinstance(feed.value, Mapping):
        return feed.value.get("from", feed)
    return feed


def sender(feed: Node) -> tuple[str, str | None] | None:
    """Stage and port that a feed names; None if it is malformed."""
    value = origin(feed).value
    named = SENDER.fullmatch(value) if isinstance(value, str) else None
    return None if named is None else (named[1], named[2])


def renamed(feed: Node, text: str) -> Node:
    """The feed from another sender."""
    named = replace(origin(feed), value=text)
    if isinstance(feed.value, Mapping):
        return replace(feed, value={**feed.value, "from": named})
    return named


def joined(outer: Node, inner: Node) -> Node:
    """The feed from the sender of `outer` into the input of `inner`, with the options of both.

    Options of `outer` count before those of `inner`; delays add up, and what both choose with `only` is left.
    """
    options = {**_options(inner), **_options(outer)}
    delays = [found["delay"] for found in (_options(inner), _options(outer)) if "delay" in found]
    if len(delays) > 1 and all(type(node.value) is int for node in delays):
        options["delay"] = replace(delays[-1], value=sum(int(str(node.value)) for node in delays))
    chosen = [found["only"] for found in (_options(outer), _options(inner)) if "only" in found]
    if len(chosen) > 1:
        options["only"] = both(*chosen)
    return replace(outer, value={"from": origin(outer), **options}) if options else origin(outer)


def with_option(feed: Node, key: str, value: Node) -> Node:
    """The feed with one more option."""
    return replace(feed, value={"from": origin(feed), **_options(feed), key: value})


def option(feed: Node, key: str) -> Node | None:
    """The value of one option; None if it is not written."""
    return _options(feed).get(key)


def seen_with(feed: Node, other: Node) -> Node:
    """The feed, whose place names that of another feed, too."""
    start = origin(feed)
    start = replace(start, place=start.place.beside(origin(other).place))
    return replace(feed, value={**feed.value, "from": start}) if isinstance(feed.value, Mapping) else start


def _options(feed: Node) -> dict[str, Node]:
    if not isinstance(feed.value, Mapping):
        return {}
    return {key: node for key, node in feed.value.items() if key != "from"}
