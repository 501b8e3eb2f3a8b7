"""The kind of a camera: the source that serves it, and whether a source gives the pictures of that kind."""

from __future__ import annotations

from followspot.errors import Mistake
from followspot.graph.instances import Instance
from followspot.plugins.registry import PluginError, load_stage
from followspot.ports.signature import ports
from followspot.room import Camera, Member, Room
from followspot.stage import Stage
from followspot.tracking import DepthImage, Frame

GIVES = {"color": Frame, "infrared": Frame, "depth": DepthImage}
"""The message type of a camera's picture by its kind; cameras of other kinds may give anything."""


def source_for(uses: str, member: Member | None, room: Room) -> str:
    """The named source, or the one by which its plugin replaces it for cameras of the member's kind."""
    camera = _camera(member, room)
    if camera is None or not uses:
        return uses
    try:
        return load_stage(uses).by_kind.get(camera.kind, uses)
    except PluginError:  # the check of the stage notes it
        return uses


def gives_picture(instance: Instance, stage: type[Stage], room: Room, mistakes: list[Mistake]) -> bool:
    """Whether a source gives frames or depth images as its camera's kind says; if not, that is noted."""
    camera = _camera(instance.member, room)
    if camera is None or not ports(stage).source:
        return True
    given = {port.type for port in ports(stage).outputs} & {Frame, DepthImage}
    wanted = GIVES.get(camera.kind)
    if not given or wanted is None or wanted in given:
        return True
    names = ", ".join(kind.__name__ for kind in given)
    text = f'camera "{camera.name}" is {camera.kind}, and its source {instance.uses} gives {names}'
    remedy = f"a source of {wanted.__name__}, or another kind of camera"
    mistakes.append(Mistake(instance.uses_place, text, remedy))
    return False


def _camera(member: Member | None, room: Room) -> Camera | None:
    return room.cameras.get(member.name) if member is not None and member.set == "cameras" else None
