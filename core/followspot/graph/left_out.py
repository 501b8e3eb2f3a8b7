"""Stages that ask for members which the room lacks: mistakes, or left out if they are optional."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from followspot.errors import Mistake
from followspot.graph.declaration import StageDeclaration
from followspot.graph.load import LoadedGraph
from followspot.graph.names import enclosing
from followspot.graph.selector import Selector, tag_named
from followspot.room import SETS, Member, Room, Target


def lacking(stage: StageDeclaration, selector: Selector, loaded: LoadedGraph, room: Room) -> Mistake:
    """The mistake that a selector, of a stage or of its sub-graph, matches nothing in the room."""
    wanted = selector.set
    if loaded.room_node is None:
        text = f'stage "{stage.name}" needs {wanted}, but the graph names no room'
        return Mistake(selector.place, text, "add room: FILE.yaml")
    unknown = selector.unknown(room)
    if unknown is not None:
        return unknown
    noun = SETS.get(wanted) or tag_named(wanted, room)
    text = f'stage "{stage.name}" needs a {noun} that the room "{room.name}" lacks'
    owners = room.members(wanted).values() if wanted in SETS else ()
    names = [o.name if isinstance(o, Target) else f"{o.name} ({o.kind})" for o in owners]
    have = ", ".join([*names, *room.tags.get(noun, ())]) or f"no {wanted}"
    remedy = f"{selector.text} matches none of: {have}"
    if selector is stage.each:
        remedy += "; or write optional: true"
    return Mistake(selector.place, text, remedy)


def stages_left_out(
    loaded: LoadedGraph, members: Mapping[str, Sequence[Member | None]]
) -> dict[str, Mistake]:
    """The stages and sub-graphs that are left out, each with the reason.

    They are the optional ones for which the room has no member, the optional ones that only such stages feed,
    and the stages within sub-graphs that are left out.
    """
    left_out = dict(loaded.left_out)
    for name, stage in loaded.stages.items():
        if not members[name] and stage.each is not None:
            text = f'stage "{name}" is left out: the room has no {stage.each.text}'
            left_out[name] = Mistake(stage.each.place, text)
    before = -1
    while len(left_out) > before:
        before = len(left_out)
        for use in loaded.optional:
            if use.name not in left_out and use.senders <= left_out.keys():
                reason = Mistake(use.place, f'sub-graph "{use.name}" is left out: so is all that feeds it')
                left_out[use.name] = reason
                left_out |= {name: reason for name in loaded.stages if use.name in enclosing(name)}
        for name, stage in loaded.stages.items():
            feeds = [feed for entry in stage.inputs for feed in entry.feeds if not feed.delay]
            unfed = bool(feeds) and all(feed.stage in left_out for feed in feeds)
            if stage.optional and unfed and name not in left_out:
                text = f'stage "{name}" is left out: so is all that feeds it'
                left_out[name] = Mistake(stage.place, text)
    return left_out
