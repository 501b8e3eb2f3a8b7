"""Second step: stages fan out over what the room has, and edges over their instances."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from followspot.document import Node, child
from followspot.errors import Mistake, Place, did_you_mean
from followspot.graph.absent import absent, lack
from followspot.graph.declaration import Feed, InputDeclaration, StageDeclaration
from followspot.graph.load import Loaded
from followspot.graph.selector import ranks, related
from followspot.room import Member, Room

ROOM_SOURCE = "room.source"
"""Stands for the source stage that the room declares for each camera or sensor."""
MAX_INSTANCES = 10_000
MAX_EDGES = 50_000
_MOST_NAMED = 6
"""Most members that a mistake names."""
_ANY = Member("", "?")
"""Stands for the members of a room that has mistakes, so that the rest of the graph is still checked."""


@dataclass(frozen=True)
class Instance:
    """One instance of a stage. uses is empty if a mistake left it unknown."""

    name: str
    declared: StageDeclaration
    member: Member | None
    uses: str
    uses_place: Place
    params: Mapping[str, Node]
    tuned: frozenset[str] = frozenset()
    """The parameters that the room tunes."""


@dataclass(frozen=True)
class Wire:
    """From an instance to an input port of another; the output port may not be named yet."""

    source: Instance
    feed: Feed
    target: Instance
    port: str
    port_place: Place


@dataclass(frozen=True)
class Expanded:
    """Every instance, in the order of the file and the room, and all that leads from one to another.

    complete: whether the room and all its members are known; else names of instances are not.
    """

    name: str
    room: Room
    room_node: Node | None
    complete: bool
    seed: int
    instances: Mapping[str, Instance]
    wires: tuple[Wire, ...]
    left_out: Mapping[str, Mistake]
    """Optional stages without an instance, each with the reason: a mistake for a stage that needs one."""
    notes: tuple[str, ...] = ()
    offered: frozenset[str] = frozenset()
    """Stages that an interface names among its outputs."""
    tuned: frozenset[Place] = frozenset()
    """Of the tunes of the room that set parameters of sub-graphs."""
    outputs: Mapping[str, tuple[Node, ...]] = field(default_factory=dict)
    """The outputs of sub-graphs, SUBGRAPH.NAME, each with what feeds a reader of it."""


_Groups = Mapping[str, Mapping[Member | None, Instance]]


def expand(loaded: Loaded, mistakes: list[Mistake]) -> Expanded:
    """Fan out; stages that are not declared and members that the room lacks are noted."""
    members = {name: _members(stage, loaded, mistakes) for name, stage in loaded.stages.items()}
    left_out = absent(loaded, members)
    count = sum(map(len, members.values()))
    if count > MAX_INSTANCES:
        return _nothing(loaded, f"the graph has {count} stages", f"at most {MAX_INSTANCES}", mistakes)
    groups = {
        name: {member: _instance(stage, member, loaded, mistakes) for member in members[name]}
        for name, stage in loaded.stages.items()
        if name not in left_out
    }
    if loaded.stages and not groups:
        remedy = "; ".join([reason.text for reason in left_out.values()][:6])
        return _nothing(
            loaded, "every stage is optional, and the room has nothing for them", remedy, mistakes
        )
    instances = _by_name(groups, mistakes)
    room = loaded.room or Room()
    rank = ranks(room)
    wires: list[Wire] = []
    unserved: dict[tuple[str, Feed], list[Member]] = {}
    for instance in instances.values():
        for entry in instance.declared.inputs:
            wires += _wires(instance, entry, groups, left_out, room, rank, unserved, mistakes)
        if len(wires) > MAX_EDGES:
            text = f"the graph has more than {MAX_EDGES} edges"
            return _nothing(loaded, text, "feed fewer inputs", mistakes)
    mistakes += [_unserved(*key, members) for key, members in unserved.items()]
    return Expanded(
        name=loaded.name,
        room=room,
        room_node=loaded.room_node,
        complete=all(one.declared.each is None or one.member for one in instances.values()),
        seed=loaded.seed,
        instances=instances,
        wires=tuple(wires),
        left_out=left_out,
        notes=tuple(dict.fromkeys(reason.text for reason in left_out.values())),
        offered=loaded.offered,
        tuned=loaded.tuned,
        outputs=loaded.outputs,
    )


def _nothing(loaded: Loaded, text: str, remedy: str, mistakes: list[Mistake]) -> Expanded:
    """No instances, because of a mistake of the whole graph."""
    first = next(iter(loaded.stages.values())).place
    mistakes.append(Mistake(first, text, remedy))
    return Expanded(loaded.name, Room(), None, False, loaded.seed, {}, (), {})


def _members(stage: StageDeclaration, loaded: Loaded, mistakes: list[Mistake]) -> Sequence[Member | None]:
    """The members that a stage fans out over; a single None if it does not fan out."""
    if stage.each is None:
        return [None]
    if loaded.room is None or not stage.each.readable:
        return [_ANY]
    found = stage.each.select(loaded.room)
    if found or stage.optional:
        return found
    mistakes.append(lack(stage, loaded, loaded.room))
    return [_ANY]


def _by_name(groups: _Groups, mistakes: list[Mistake]) -> dict[str, Instance]:
    """Every instance by its name; notes two of one name."""
    instances: dict[str, Instance] = {}
    for group in groups.values():
        for instance in group.values():
            other = instances.setdefault(instance.name, instance)
            if other is not instance:
                text = (
                    f'"{instance.name}" names an instance of stage "{other.declared.name}" and another stage'
                )
                place = instance.declared.place.beside(other.declared.place)
                mistakes.append(Mistake(place, text, "rename one of the stages"))
    return instances


def _instance(
    stage: StageDeclaration, member: Member | None, loaded: Loaded, mistakes: list[Mistake]
) -> Instance:
    name = stage.name if member is None else f"{stage.name}/{member.name}"
    known = None if member == _ANY else member
    if stage.uses != ROOM_SOURCE:
        return Instance(name, stage, known, stage.uses, stage.uses_place, stage.params)
    if member is None or (known is not None and known.set not in ("cameras", "sensors")):
        text = f'stage "{stage.name}" uses {ROOM_SOURCE} but serves no camera and no sensor'
        mistakes.append(Mistake(stage.place, text, "add each: cameras, or each: sensors"))
        known = None
    source = None if known is None else _declared_source(known, stage, loaded, mistakes)
    if source is None:
        return Instance(name, stage, known, "", stage.uses_place, {})
    use, params = source
    return Instance(name, stage, known, str(use.value), use.place, {**params, **stage.params})


def _declared_source(
    member: Member, stage: StageDeclaration, loaded: Loaded, mistakes: list[Mistake]
) -> tuple[Node, Mapping[str, Node]] | None:
    """The source of a camera or sensor in the room: the name of the stage and the parameters."""
    entry = child(child(loaded.room_node, member.set), member.name)
    source = child(entry, "source")
    use = child(source, "uses")
    if use is None:
        text = f'{member.noun} "{member.name}" has no source, and stage "{stage.name}" needs it'
        remedy = "add source: {uses: STAGE, with: {...}}"
        mistakes.append(Mistake(entry.key if entry is not None else stage.place, text, remedy))
        return None
    params = child(source, "with")
    return use, params.value if params is not None and isinstance(params.value, Mapping) else {}


def _wires(
    target: Instance,
    entry: InputDeclaration,
    groups: _Groups,
    left_out: Collection[str],
    room: Room,
    rank: Mapping[Member, int],
    unserved: dict[tuple[str, Feed], list[Member]],
    mistakes: list[Mistake],
) -> list[Wire]:
    """All wires to one input, in the order of the room, for a join delivers in that order.

    Of several senders that fan out, such as sub-graphs of each camera, those feed the target that serve its
    member; a target for which none does is added to `unserved`.
    """
    wires, strange = [], []
    for feed in entry.feeds:
        sources = groups.get(feed.stage)
        if sources is not None:
            found = _sources(target, feed, sources, room, mistakes)
            wires += [Wire(source, feed, target, entry.port, entry.place) for source in found or ()]
            strange += [feed] if found is None else []
        elif feed.stage not in left_out:
            remedy = did_you_mean(feed.stage, groups, "stages")
            mistakes.append(Mistake(feed.place, f'there is no stage "{feed.stage}"', remedy))
    if strange and not wires and target.member is not None:
        unserved.setdefault((target.declared.name, strange[0]), []).append(target.member)
    last = len(rank)
    return sorted(wires, key=lambda w: last if w.source.member is None else rank.get(w.source.member, last))


def _unserved(stage: str, feed: Feed, members: Sequence[Member]) -> Mistake:
    """The mistake of a stage with members that its sender does not serve."""
    listed = ", ".join(map(str, members[:_MOST_NAMED]))
    listed += f" and {len(members) - _MOST_NAMED} more" if len(members) > _MOST_NAMED else ""
    text = f'stage "{stage}" serves {listed}, stage "{feed.stage}" does not'
    return Mistake(feed.place, text, "give both the same each")


def _sources(
    target: Instance,
    feed: Feed,
    sources: Mapping[Member | None, Instance],
    room: Room,
    mistakes: list[Mistake],
) -> Collection[Instance] | None:
    """The instances that feed a target: those of its own or related members, else all of the stage.

    None if the stage serves other members only.
    """
    unknown = target.declared.each is not None and target.member is None
    if feed.only is not None and not feed.only.readable:
        return [next(iter(sources.values()))]
    if feed.only is not None and _ANY not in sources and not unknown:
        chosen = feed.only.select(room)
        sources = {member: source for member, source in sources.items() if member in chosen}
        if not sources:
            text = f'no instance of stage "{feed.stage}" serves {feed.only.text}'
            mistakes.append(Mistake(feed.place, text, "change the selector, or leave it out"))
            return []
    first = next(iter(sources.values()))
    if target.declared.each is None or first.declared.each is None:
        return sources.values()
    if target.member is None or first.member is None:
        return [first]  # which member is not known because of a mistake
    wanted = related(room, target.member, first.member.set)
    if wanted is None:
        return sources.values()
    return [sources[member] for member in wanted if member in sources] or None
