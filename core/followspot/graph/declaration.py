"""The declarations of a graph file: stages, their inputs, parameters and policies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import cast

from followspot.errors import Mistake, Place
from followspot.graph.depths import MAX_DEPTH
from followspot.graph.names import SENDER, is_stage_name
from followspot.graph.plan import (
    MAX_CONCURRENCY,
    MAX_DELAY,
    EdgeCodec,
    EdgePolicy,
    ErrorPolicy,
    PlannedEdge,
    PlannedStage,
)
from followspot.graph.selector import Selector, read_selector
from followspot.stage_params import ENVELOPE
from followspot.valid_values.numbers import MAX_WAIT
from followspot.yaml.form import Form, kind_of
from followspot.yaml.node import Node

ROOM_SOURCE = "room.source"
"""Stands for the source stage that the room declares for each camera or sensor."""
_POLICIES = ("fail", "skip", "restart")
_FEED = ("from", "only", "delay", "depth", "codec", "policy", "tolerance")
_CODECS = ("raw", "lossless", "jpeg")
_EDGE_POLICIES = ("block", "drop_oldest", "latest")


@dataclass(frozen=True)
class Feed:
    """The sender of an input port: a stage, and a port if one is named."""

    stage: str
    port: str | None
    delay: int
    depth: int
    codec: EdgeCodec
    policy: EdgePolicy
    place: Place
    tolerance: float | None = None
    only: Selector | None = None
    """The members of the sender's stage that feed the input, if not all of them may."""
    places: Mapping[str, Place] = field(default_factory=dict, compare=False)
    """Places of the other settings, by key."""

    @property
    def origin(self) -> str:
        """The sender as it is written."""
        return self.stage if self.port is None else f"{self.stage}.{self.port}"


@dataclass(frozen=True)
class InputDeclaration:
    """An input port by name, with all that leads to it."""

    port: str
    place: Place
    feeds: tuple[Feed, ...]


@dataclass(frozen=True)
class StageDeclaration:
    """A stage as it is written; `params` keeps the nodes, for mistakes are found in them later."""

    name: str
    place: Place
    uses: str
    uses_place: Place
    each: Selector | None
    inputs: tuple[InputDeclaration, ...]
    params: Mapping[str, Node]
    on_error: ErrorPolicy
    tolerance: float | None
    """None for that of the stage class."""
    deadline: float
    optional: bool = False
    """True if the room may lack all that the stage fans out over; the stage is left out then."""
    depth: int | None = None
    """None for the depth that fits the source's rate."""
    concurrency: int = 1
    serves: tuple[Selector, ...] = ()
    """The members of sub-graphs that fan out around the stage: of other members it takes nothing."""
    sees: tuple[Selector, ...] = ()
    """The cameras that the sub-graphs around the stage are given: it knows no others."""
    places: Mapping[str, Place] = field(default_factory=dict, compare=False)
    """Of the value of each key that is written."""


def read_stage(name: str, node: Node, mistakes: list[Mistake]) -> StageDeclaration:
    """Read one entry of `stages`; note mistakes, and replace wrong values by defaults."""
    if not is_stage_name(name):
        remedy = "use 1 to 100 letters, digits, _ and -; / leads into a sub-graph"
        mistakes.append(Mistake(node.key, f'"{name}" cannot be the name of a stage', remedy))
    form = Form(node, f'stage "{name}"', ENVELOPE, mistakes)
    each = form.get("each")
    deadline = form.number("deadline", least=0.0, most=MAX_WAIT)
    return StageDeclaration(
        name=name,
        place=node.key,
        uses=form.text("uses", required=True) or "",
        uses_place=form.entries["uses"].place if "uses" in form.entries else node.key,
        each=None if each is None else read_selector(each, mistakes),
        inputs=tuple(_input(port, feeds, mistakes) for port, feeds in form.mapping("in").items()),
        params=form.mapping("with"),
        on_error=cast(ErrorPolicy, form.text("on_error", choices=_POLICIES) or "fail"),
        tolerance=form.number("tolerance", least=0.0, most=MAX_WAIT),
        deadline=PlannedStage.deadline if deadline is None else deadline,
        optional=form.switch("optional"),
        depth=form.whole("depth", least=1, most=MAX_DEPTH),
        concurrency=form.whole("concurrency", least=1, most=MAX_CONCURRENCY) or PlannedStage.concurrency,
        serves=_selectors(form, "serves", mistakes),
        sees=_selectors(form, "sees", mistakes),
        places=_places(form),
    )


def _selectors(form: Form, key: str, mistakes: list[Mistake]) -> tuple[Selector, ...]:
    """The selectors of a list, or the only one."""
    node = form.get(key)
    if node is None:
        return ()
    items = node.value if isinstance(node.value, tuple) else (node,)
    found = (read_selector(item, mistakes, key) for item in items)
    return tuple(selector for selector in found if selector.readable)


def _places(form: Form) -> dict[str, Place]:
    return {key: node.place for key, node in form.entries.items()}


def _input(port: str, node: Node, mistakes: list[Mistake]) -> InputDeclaration:
    items = node.value if isinstance(node.value, tuple) else (node,)
    if not items:
        mistakes.append(Mistake(node.place, f'input "{port}" is fed by nothing', "name a stage"))
    feeds = [_feed(item, mistakes) for item in items]
    return InputDeclaration(port, node.key, tuple(feed for feed in feeds if feed is not None))


def _feed(node: Node, mistakes: list[Mistake]) -> Feed | None:
    """One sender of an input; None if its name cannot be read."""
    delay, depth, codec = 0, PlannedEdge.depth, PlannedEdge.codec
    policy, tolerance = PlannedEdge.policy, PlannedEdge.tolerance
    chosen: Selector | None = None
    origin: Node | None = node
    places: Mapping[str, Place] = {}
    if isinstance(node.value, Mapping):
        form = Form(node, "an input", _FEED, mistakes)
        only = form.get("only")
        chosen = None if only is None else read_selector(only, mistakes, "only")
        origin = form.get("from", required=True)
        places = _places(form)
        delay = _delay(form)
        codec = cast(EdgeCodec, form.text("codec", choices=_CODECS) or codec)
        policy = _policy(form, delay, mistakes)
        tolerance = form.number("tolerance", least=0.0, most=MAX_WAIT)
        depth = form.whole("depth", least=1, most=MAX_DEPTH) or (1 if policy == "latest" else depth)
    if origin is None:
        return None
    named = SENDER.fullmatch(origin.value) if isinstance(origin.value, str) else None
    if named is None:
        text = f"an input is fed from STAGE or STAGE.PORT, not {kind_of(origin)}"
        mistakes.append(Mistake(origin.place, text, "for example: track, or track.forecast"))
        return None
    return Feed(
        stage=named[1],
        port=named[2],
        delay=delay,
        depth=depth,
        codec=codec,
        policy=policy,
        place=origin.place,
        tolerance=tolerance,
        only=chosen,
        places=places,
    )


def _delay(form: Form) -> int:
    """Firings back; 1 for a wrong value, with which a cycle is no further mistake."""
    if "delay" not in form.entries:
        return 0
    delay = form.whole("delay", least=0, most=MAX_DELAY)
    return 1 if delay is None else delay


def _policy(form: Form, delay: int, mistakes: list[Mistake]) -> EdgePolicy:
    """The policy of a full edge. An edge that drops has no delay: it cannot deliver the message of a certain
    time.
    """
    policy = cast(EdgePolicy, form.text("policy", choices=_EDGE_POLICIES) or PlannedEdge.policy)
    if delay and policy != "block":
        text = f"an edge with a delay waits for exactly its message and cannot be {policy}"
        mistakes.append(Mistake(form.entries["policy"].place, text, "remove the policy or the delay"))
        return "block"
    return policy
