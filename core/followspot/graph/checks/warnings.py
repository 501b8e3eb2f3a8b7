"""Warnings about stages of a valid graph that can never give a result; they do not stop a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from operator import or_

from followspot.errors import Mistake
from followspot.graph.checks.flow import Flow
from followspot.graph.checks.lengths import implausible_lengths
from followspot.graph.checks.lenses import folded_lenses
from followspot.graph.checks.rates import joins_of_unequal_rates
from followspot.graph.checks.shared_containers import shared_containers
from followspot.graph.connections import CheckedEdge
from followspot.graph.distinct_mistakes import distinct_mistakes
from followspot.graph.expand import ExpandedGraph
from followspot.graph.instances import CheckedStage, Instance
from followspot.graph.seen_cameras import seen_cameras
from followspot.ports.signature import ports
from followspot.room import Camera, Member, Room, Sensor
from followspot.stage import Stage
from followspot.yaml.node import Node, child

MOST_NAMED = 6
"""Most cameras that a warning names."""


def warnings(flow: Flow, expanded: ExpandedGraph) -> list[Mistake]:
    """Everything in a graph without mistakes that can never give a result, at its place."""
    room = expanded.room
    found = [
        *_unread(flow, expanded),
        *_unused(flow, room, expanded.room_node),
        *_never(flow),
        *joins_of_unequal_rates(flow, room),
        *_foreseen(flow, room),
        *implausible_lengths(room, expanded.room_node),
        *folded_lenses(room, expanded.room_node),
        *shared_containers(flow),
    ]
    return [replace(mistake, warning=True) for mistake in distinct_mistakes(found)]


def _unread(flow: Flow, expanded: ExpandedGraph) -> Iterator[Mistake]:
    """Stages with outputs that feed nothing, or that feed nothing for some cameras."""
    read = {edge.wire.source.name for edge in flow.edges}
    for name, group in flow.groups.items():
        idle = [one.instance for one in group if one.instance.name not in read]
        if not idle or name in expanded.offered or not ports(group[0].stage).outputs:
            continue
        declared = group[0].instance.declared
        if len(idle) == len(group):
            text = f'no stage reads what stage "{name}" ({idle[0].uses}) gives'
            yield Mistake(declared.place, text, "feed a stage or a sink from it, or remove it")
        else:
            members = _listed([one.member for one in idle if one.member], expanded.room)
            text = f'no stage reads what stage "{name}" gives for {members}'
            place = declared.each.place if declared.each is not None else declared.place
            yield Mistake(place, text, "add a stage for these, or narrow its each")


def _unused(flow: Flow, room: Room, node: Node | None) -> Iterator[Mistake]:
    """Cameras that no stage serves, in a graph that serves other cameras; sensors likewise."""
    served = {checked.instance.member for checked in flow.stages.values()} - {None}
    for kind, names in (("cameras", room.cameras), ("sensors", room.sensors)):
        idle = [member for name in names if (member := Member(kind, name)) not in served]
        if idle and any(member.set == kind for member in served if member):
            entry = child(child(node, kind), idle[0].name)
            text = f"no stage serves {_listed(idle, room)}"
            place = entry.key if entry is not None else None
            yield Mistake(place, text, f"each: {kind} serves all {kind} of the room")


def _camera(instance: Instance) -> str:
    """The name of the camera that an instance serves, empty if it serves none."""
    return instance.member.name if instance.member and instance.member.set == "cameras" else ""


def _listed(members: Sequence[Member], room: Room) -> str:
    """For example: cameras cam1 (infrared), cam3 (infrared)."""
    kinds: Mapping[str, Mapping[str, Camera | Sensor]] = {"cameras": room.cameras, "sensors": room.sensors}
    shown = [m.name + (f" ({kinds[m.set][m.name].kind})" if m.set in kinds else "") for m in members]
    more = f" and {len(shown) - MOST_NAMED} more" if len(shown) > MOST_NAMED else ""
    return f"{members[0].noun}{'s' * (len(shown) > 1)} {', '.join(shown[:MOST_NAMED])}{more}"


def _never(flow: Flow) -> Iterator[Mistake]:
    """A warning for each stage that never fires, unless a stage that feeds it never fires, either."""
    firing, into = _firing(flow), flow.firing_edges
    for name, group in flow.groups.items():
        still = [one.instance.name for one in group if one.instance.name not in firing]
        if still and not any(edge.wire.source.name not in firing for i in still for edge in into[i]):
            text = f'stage "{name}" never fires: all its inputs are sampled or delayed'
            remedy = "feed it without a delay from a source, or from a stage that a source feeds"
            yield Mistake(group[0].instance.declared.place, text, remedy)


def _firing(flow: Flow) -> set[str]:
    """Instances that messages of a source can reach at every required input that fires."""
    found: set[str] = set()
    for name in flow.order:
        stage = flow.stages[name].stage
        if ports(stage).source or _fed(stage, flow.firing_edges[name], found):
            found.add(name)
    return found


def _fed(stage: type[Stage], edges: Sequence[CheckedEdge], firing: set[str]) -> bool:
    """Whether every required input that fires has a sender that fires, and at least one input has."""
    live = {edge.wire.port for edge in edges if edge.wire.source.name in firing}
    required = {port.name for port in ports(stage).inputs if port.required}
    return bool(live) and required & {edge.wire.port for edge in edges} <= live


def _foreseen(flow: Flow, room: Room) -> Iterator[Mistake]:
    """Warnings that the stages themselves give for the room and the cameras that reach them."""
    reach = _cameras(flow, list(room.cameras))
    for group in flow.groups.values():
        first = group[0]
        seen = reduce(or_, (reach[one.instance.name] for one in group))
        cameras = [camera for bit, camera in enumerate(room.cameras.values()) if seen >> bit & 1]
        for mistake in _said(first, room.with_cameras(seen_cameras(first, room)), cameras):
            yield replace(mistake, place=mistake.place or first.instance.declared.place)


def _said(checked: CheckedStage, room: Room, cameras: Sequence[Camera]) -> list[Mistake]:
    """The result of `check_room`; that it fails is a warning itself."""
    try:
        return list(checked.stage.check_room(checked.stage.Params(**checked.params), room, cameras))
    except Exception as error:  # the code of a plugin may do anything
        text = f"{checked.instance.uses}.check_room failed: {type(error).__name__}: {error}"
        return [Mistake(None, text, "tell the author of the plugin")]


def _cameras(flow: Flow, cameras: Sequence[str]) -> dict[str, int]:
    """The cameras whose messages each instance gets, its own included, as bits in the order of the room."""
    bit = {name: 1 << number for number, name in enumerate(cameras)}
    reach = {name: bit.get(_camera(one.instance), 0) for name, one in flow.stages.items()}
    for source in flow.order:
        for target in flow.after[source]:
            reach[target] |= reach[source]
    return reach
