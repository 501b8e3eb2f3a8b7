"""Second step: one instance of a stage for each member of the room, and edges between the instances."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from followspot.errors import Mistake, Place
from followspot.graph.camera_kind import source_for
from followspot.graph.declaration import ROOM_SOURCE, StageDeclaration
from followspot.graph.instances import ANY, Groups, Instance, Wire
from followspot.graph.left_out import lacking, stages_left_out
from followspot.graph.load import LoadedGraph
from followspot.graph.subgraph_use import SubgraphUse
from followspot.graph.wiring import InstanceWiring
from followspot.room import Member, Room
from followspot.yaml.node import Node, child

MAX_INSTANCES = 10_000
MAX_EDGES = 50_000


@dataclass(frozen=True)
class ExpandedGraph:
    """Every instance, in the order of the file and the room, and the wires between them.

    complete: whether the room and all its members are known; else some names of instances are unknown.
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
    unserved: tuple[Instance, ...] = ()
    """One instance of each stage that is left out, so that its entry is checked, too."""
    notes: tuple[str, ...] = ()
    offered: frozenset[str] = frozenset()
    """Stages that an interface names among its outputs."""
    tuned: frozenset[Place] = frozenset()
    """Places of the room's tunes that set parameters of sub-graphs."""
    outputs: Mapping[str, tuple[Node, ...]] = field(default_factory=dict)
    """The outputs of sub-graphs, SUBGRAPH.NAME, each with what feeds a reader of it."""
    subgraphs: tuple[SubgraphUse, ...] = ()


def expand(loaded: LoadedGraph, mistakes: list[Mistake]) -> ExpandedGraph:
    """Fan out the stages over members of the room; note unknown stages and missing members."""
    members = {name: _members(stage, loaded, mistakes) for name, stage in loaded.stages.items()}
    left_out = stages_left_out(loaded, members)
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
    wiring = InstanceWiring(groups, left_out, room, mistakes)
    wires: list[Wire] = []
    for instance in instances.values():
        wires += wiring.into(instance)
        if len(wires) > MAX_EDGES:
            text = f"the graph has more than {MAX_EDGES} edges"
            return _nothing(loaded, text, "feed fewer inputs", mistakes)
    mistakes += wiring.unserved()
    return ExpandedGraph(
        name=loaded.name,
        room=room,
        room_node=loaded.room_node,
        complete=all(one.declared.each is None or one.member for one in instances.values()),
        seed=loaded.seed,
        instances=instances,
        wires=tuple(wires),
        left_out=left_out,
        unserved=tuple(_unserved(loaded, left_out)),
        notes=tuple(dict.fromkeys(reason.text for reason in left_out.values())),
        offered=loaded.offered,
        tuned=loaded.tuned,
        outputs=loaded.outputs,
        subgraphs=loaded.subgraphs,
    )


def _unserved(loaded: LoadedGraph, left_out: Collection[str]) -> Iterator[Instance]:
    """An instance, for an unknown member, of each stage that is left out."""
    for stage in (*(loaded.stages[name] for name in left_out if name in loaded.stages), *loaded.apart):
        yield _instance(stage, ANY, loaded, [])


def _nothing(loaded: LoadedGraph, text: str, remedy: str, mistakes: list[Mistake]) -> ExpandedGraph:
    """A graph without instances, because of a mistake that concerns the whole graph, which is noted."""
    first = next(iter(loaded.stages.values())).place
    mistakes.append(Mistake(first, text, remedy))
    return ExpandedGraph(
        name=loaded.name,
        room=Room(),
        room_node=None,
        complete=False,
        seed=loaded.seed,
        instances={},
        wires=(),
        left_out={},
    )


def _members(
    stage: StageDeclaration, loaded: LoadedGraph, mistakes: list[Mistake]
) -> Sequence[Member | None]:
    """The members that a stage fans out over; a single None if it does not fan out."""
    if loaded.room is not None:
        empty = (served for served in (*stage.serves, *stage.sees) if not served.select(loaded.room))
        mistakes += [lacking(stage, served, loaded, loaded.room) for served in empty]
    if stage.each is None:
        return [None]
    if loaded.room is None or not stage.each.readable:
        return [ANY]
    found = stage.each.select(loaded.room)
    if found or stage.optional:
        return found
    mistakes.append(lacking(stage, stage.each, loaded, loaded.room))
    return [ANY]


def _by_name(groups: Groups, mistakes: list[Mistake]) -> dict[str, Instance]:
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
    stage: StageDeclaration, member: Member | None, loaded: LoadedGraph, mistakes: list[Mistake]
) -> Instance:
    """The instance of a stage for a member; its plugin stage is "" if a mistake leaves it unknown."""
    name = stage.name if member is None else f"{stage.name}/{member.name}"
    known = None if member == ANY else member
    room = loaded.room or Room()
    if stage.uses != ROOM_SOURCE:
        uses = source_for(stage.uses, known, room)
        return Instance(name, stage, known, uses, stage.uses_place, stage.params)
    if member is None or (known is not None and known.set not in ("cameras", "sensors")):
        text = f'stage "{stage.name}" uses {ROOM_SOURCE} but serves no camera and no sensor'
        mistakes.append(Mistake(stage.place, text, "add each: cameras, or each: sensors"))
        known = None
    source = None if known is None else _declared_source(known, stage, loaded, mistakes)
    if source is None:
        return Instance(name, stage, known, "", stage.uses_place, {})
    use, params = source
    uses = source_for(str(use.value), known, room)
    return Instance(name, stage, known, uses, use.place, {**params, **stage.params})


def _declared_source(
    member: Member, stage: StageDeclaration, loaded: LoadedGraph, mistakes: list[Mistake]
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
