"""The part of the room that a stage knows: the cameras of the sub-graphs around it."""

from __future__ import annotations

from followspot.graph.instances import CheckedStage
from followspot.graph.selector import related
from followspot.ports.signature import ports
from followspot.room import Member, Room


def seen_cameras(checked: CheckedStage, room: Room) -> tuple[str, ...] | None:
    """Names of the cameras that the sub-graphs around a stage are given, in the order of the room.

    None for all cameras: outside such sub-graphs, and for sources, whose device or renderer does not depend
    on the sub-graph.
    """
    if ports(checked.stage).source:
        return None
    names = set(room.cameras)
    for seen in checked.instance.declared.sees:
        names &= {member.name for member in seen.select(room)}
    for member in (m for served in checked.instance.declared.serves for m in served.select(room)):
        names &= _cameras_of(member, room)
    return tuple(name for name in room.cameras if name in names) if len(names) < len(room.cameras) else None


def _cameras_of(member: Member, room: Room) -> set[str]:
    found = related(room, member, "cameras")
    return set(room.cameras) if found is None else {camera.name for camera in found}
