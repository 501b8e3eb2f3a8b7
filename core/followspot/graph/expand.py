"""Second step: stages fan out over the cameras of the room, and edges over their instances."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from followspot.document import Node, child
from followspot.errors import Mistake, Place, did_you_mean
from followspot.graph.declaration import Feed, InputDeclaration, StageDeclaration
from followspot.graph.load import Loaded
from followspot.room import Room

ROOM_SOURCE = "room.source"
"""Stands for the source stage that the room declares for each camera."""
MAX_INSTANCES = 10_000
MAX_EDGES = 50_000
_ANY_CAMERA = "?"
"""Stands for the cameras of a room that has mistakes, so that the rest of the graph is still checked."""


@dataclass(frozen=True)
class Instance:
    """One instance of a stage. uses is empty if a mistake left it unknown."""

    name: str
    declared: StageDeclaration
    camera: str | None
    uses: str
    uses_place: Place
    params: Mapping[str, Node]


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

    complete: whether the room and all its cameras are known; else names of instances are not.
    """

    name: str
    room: Room
    room_node: Node | None
    complete: bool
    seed: int
    instances: Mapping[str, Instance]
    wires: tuple[Wire, ...]


def expand(loaded: Loaded, mistakes: list[Mistake]) -> Expanded:
    """Fan out; stages that are not declared and cameras that the room lacks are noted."""
    cameras = {name: _cameras(stage, loaded, mistakes) for name, stage in loaded.stages.items()}
    count = sum(map(len, cameras.values()))
    if count > MAX_INSTANCES:
        return _too_large(loaded, f"{count} stages", f"at most {MAX_INSTANCES}", mistakes)
    groups = {
        name: {camera: _instance(stage, camera, loaded, mistakes) for camera in cameras[name]}
        for name, stage in loaded.stages.items()
    }
    instances = {instance.name: instance for group in groups.values() for instance in group.values()}
    rank = {camera: number for number, camera in enumerate(loaded.room.cameras if loaded.room else ())}
    wires: list[Wire] = []
    for instance in instances.values():
        for entry in instance.declared.inputs:
            wires += _wires(instance, entry, groups, rank, mistakes)
        if len(wires) > MAX_EDGES:
            return _too_large(loaded, f"more than {MAX_EDGES} edges", "feed fewer inputs", mistakes)
    room = loaded.room or Room()
    complete = all(instance.declared.each is None or instance.camera for instance in instances.values())
    return Expanded(loaded.name, room, loaded.room_node, complete, loaded.seed, instances, tuple(wires))


def _too_large(loaded: Loaded, what: str, remedy: str, mistakes: list[Mistake]) -> Expanded:
    """Nothing, for the graph has too much of something."""
    first = next(iter(loaded.stages.values())).place
    mistakes.append(Mistake(first, f"the graph has {what}", remedy))
    return Expanded(loaded.name, Room(), None, False, loaded.seed, {}, ())


def _cameras(stage: StageDeclaration, loaded: Loaded, mistakes: list[Mistake]) -> Sequence[str | None]:
    """The cameras that a stage fans out over; a single None if it does not fan out."""
    if stage.each is None:
        return [None]
    if loaded.room is None:
        return [_ANY_CAMERA]
    found = stage.each.select(loaded.room.cameras)
    if found:
        return found
    if loaded.room_node is None:
        text, remedy = (
            f'stage "{stage.name}" needs cameras, but the graph names no room',
            "add room: FILE.yaml",
        )
    else:
        text = f'stage "{stage.name}" needs a camera that the room "{loaded.room.name}" lacks'
        have = ", ".join(f"{camera.name} ({camera.kind})" for camera in loaded.room.cameras.values())
        remedy = f"{stage.each.text} matches none of: {have or 'no cameras'}"
    mistakes.append(Mistake(stage.each.place, text, remedy))
    return [_ANY_CAMERA]


def _instance(
    stage: StageDeclaration, camera: str | None, loaded: Loaded, mistakes: list[Mistake]
) -> Instance:
    name = stage.name if camera is None else f"{stage.name}/{camera}"
    known = None if camera == _ANY_CAMERA else camera
    if stage.uses != ROOM_SOURCE:
        return Instance(name, stage, known, stage.uses, stage.uses_place, stage.params)
    if camera is None:
        remedy = "add each: cameras"
        mistakes.append(
            Mistake(stage.place, f'stage "{stage.name}" uses {ROOM_SOURCE} but serves no camera', remedy)
        )
    source = None if known is None else _declared_source(known, stage, loaded, mistakes)
    if source is None:
        return Instance(name, stage, known, "", stage.uses_place, {})
    use, params = source
    return Instance(name, stage, known, str(use.value), use.place, {**params, **stage.params})


def _declared_source(
    camera: str, stage: StageDeclaration, loaded: Loaded, mistakes: list[Mistake]
) -> tuple[Node, Mapping[str, Node]] | None:
    """The source of a camera in the room: the name of the stage and the parameters."""
    entry = child(child(loaded.room_node, "cameras"), camera)
    source = child(entry, "source")
    use = child(source, "uses")
    if use is None:
        text = f'camera "{camera}" has no source, and stage "{stage.name}" needs it'
        remedy = "add source: {uses: STAGE, with: {...}}"
        mistakes.append(Mistake(entry.key if entry is not None else stage.place, text, remedy))
        return None
    params = child(source, "with")
    return use, params.value if params is not None and isinstance(params.value, Mapping) else {}


def _wires(
    target: Instance,
    entry: InputDeclaration,
    groups: Mapping[str, Mapping[str | None, Instance]],
    rank: Mapping[str, int],
    mistakes: list[Mistake],
) -> list[Wire]:
    """All wires to one input, in the order of the room's cameras, for a join delivers in that order."""
    wires = [
        Wire(source, feed, target, entry.port, entry.place)
        for feed in entry.feeds
        for source in _sources(target, feed, groups, mistakes)
    ]
    return sorted(wires, key=lambda wire: rank.get(wire.source.camera or "", len(rank)))


def _sources(
    target: Instance,
    feed: Feed,
    groups: Mapping[str, Mapping[str | None, Instance]],
    mistakes: list[Mistake],
) -> Collection[Instance]:
    """The instance for the same camera if both stages fan out; else every instance of the stage."""
    sources = groups.get(feed.stage)
    if sources is None:
        remedy = did_you_mean(feed.stage, groups, "stages")
        mistakes.append(Mistake(feed.place, f'there is no stage "{feed.stage}"', remedy))
        return []
    first = next(iter(sources.values()))
    if target.declared.each is None or first.declared.each is None:
        return sources.values()
    if target.camera is None or first.camera is None:
        return [first]  # which camera is not known because of a mistake
    same = sources.get(target.camera)
    if same is not None:
        return [same]
    text = f'stage "{target.declared.name}" serves camera {target.camera}, stage "{feed.stage}" does not'
    mistakes.append(Mistake(feed.place, text, "give both the same each"))
    return []
