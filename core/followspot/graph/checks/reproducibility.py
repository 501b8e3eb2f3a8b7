"""Everything in a plan that can make two runs differ: `check --strict` refuses it.

The use of clocks or random numbers in the code of a stage does not show in a plan.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from followspot.errors import Mistake
from followspot.graph.connections import CheckedEdge
from followspot.graph.instances import CheckedStage
from followspot.graph.sampling import sampled_cycles

_RECORD = "record the run and replay it"


def risks(stages: Sequence[CheckedStage], edges: Sequence[CheckedEdge]) -> list[Mistake]:
    """A mistake for each reason, at its place in the graph or the room; once for all cameras."""
    found = [*_anywhere(stages), *_lossy(edges)]
    if any(checked.stage.live for checked in stages):
        found += [*_live(stages), *_sampled(edges), *_dropping(edges), *_deadlines(edges)]
    return list(dict.fromkeys(found))


def _anywhere(stages: Sequence[CheckedStage]) -> Iterator[Mistake]:
    """Reasons that also hold for replays."""
    for checked in stages:
        declared = checked.instance.declared
        if declared.on_error != "fail":
            text = f'stage "{declared.name}" goes on after an error, which need not come again'
            place = declared.places.get("on_error", declared.place)
            yield Mistake(place, text, "on_error: fail")
        if checked.params.get("seed", 0) is None:
            text = f'stage "{declared.name}" ({checked.instance.uses}) draws random numbers without a seed'
            yield Mistake(checked.instance.uses_place, text, "with: {seed: 1}")


def _lossy(edges: Sequence[CheckedEdge]) -> Iterator[Mistake]:
    for edge in edges:
        feed = edge.wire.feed
        if feed.codec == "jpeg":
            text = f'input "{edge.wire.port}" gets other pictures over Zenoh than from the same host'
            yield Mistake(feed.places.get("codec", feed.place), text, "codec: lossless")


def _live(stages: Sequence[CheckedStage]) -> Iterator[Mistake]:
    for checked in stages:
        if checked.stage.live:
            declared = checked.instance.declared
            text = f'stage "{declared.name}" ({checked.instance.uses}) is live: nothing comes twice'
            yield Mistake(checked.instance.uses_place, text, _RECORD)


def _sampled(edges: Sequence[CheckedEdge]) -> Iterator[Mistake]:
    """Sampled inputs; those in cycles are named with their cycle."""
    in_cycles = sampled_cycles(edge.flow_edge for edge in edges)
    places = {mistake.place for mistake in in_cycles}
    yield from in_cycles
    for edge in edges:
        feed = edge.wire.feed
        if edge.sampled and feed.place not in places:
            end = edge.wire.target.declared.name
            text = f'input "{edge.wire.port}" of stage "{end}" takes the newest message that has arrived'
            yield Mistake(feed.place, text, f"replay the run, or delay it: {{from: {feed.origin}, delay: 1}}")


def _dropping(edges: Sequence[CheckedEdge]) -> Iterator[Mistake]:
    for edge in edges:
        feed = edge.wire.feed
        if feed.policy != "block":
            text = f'input "{edge.wire.port}" loses messages if its stage is slow'
            yield Mistake(feed.places.get("policy", feed.place), text, "policy: block")


def _deadlines(edges: Sequence[CheckedEdge]) -> Iterator[Mistake]:
    """Joins of live runs, which do not wait for late messages."""
    members = Counter(edge.wire.target.name for edge in edges if not edge.held)
    for edge in edges:
        declared = edge.wire.target.declared
        if members[edge.wire.target.name] > 1:
            text = f'stage "{declared.name}" goes on without what is {declared.deadline:g} s late'
            yield Mistake(
                declared.places.get("deadline", declared.place), text, "replay the run: it waits for all"
            )
